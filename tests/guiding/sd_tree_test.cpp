#include "core/guiding/sd_tree.h"

#include <gtest/gtest.h>

#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

using synthetic::Train;
using synthetic::Training;

TEST(SdTree, SampledPdfIsThePdfOfTheDirection) {
  Training training;
  training.options.spatial_threshold = 1000;
  const auto tree = Train(training, 5);
  ASSERT_GT(tree->leaf_count(), 50u);
  uint64_t rng = 5;
  for (int i = 0; i < 1000000; ++i) {
    const uint32_t leaf = tree->LeafAt(synthetic::Unit3(rng));
    const GuidedSample s = tree->Sample(leaf, synthetic::Unit2(rng));
    ASSERT_GT(s.pdf, 0);
    ASSERT_EQ(s.pdf, tree->Pdf(leaf, s.w)) << i;
  }
}

// A tree whose only light is one point: cells of depth 20, as wide as sixteen steps of a float.
std::shared_ptr<const SdTree> DeepestTree(Vec3 w) {
  SdTreeOptions options;
  options.directional_filter = SdTreeOptions::DirectionalFilter::kNearest;
  options.min_records = 1;
  auto tree = SdTree::Initial(synthetic::UnitCube(), options);
  for (int k = 0; k < 25; ++k) {
    SdTreeStatistics statistics(tree);
    SdTreeRecord r;
    r.direction = w;
    r.radiance = r.pdf = 1;
    statistics.Record(r, {0.5f, 0.5f, 0.5f});
    tree = Advance(*tree, statistics, 4);
  }
  return tree;
}

TEST(SdTree, SamplesOfTheDeepestCellsStayInThem) {
  for (const Vec3 w : {Normalize(Vec3{1, 2, 3}), Vec3{0, 0, 1}, Vec3{0, 0, -1}, Normalize(Vec3{1, -1e-6f, 0.2f}),
                       Normalize(Vec3{-1, 0, 0.5f})}) {
    const auto tree = DeepestTree(w);
    ASSERT_EQ(tree->leaf(0).depth, 20);
    const float expected = tree->Pdf(0, w);
    EXPECT_GT(expected, 1e10f);
    uint64_t rng = 3;
    int elsewhere = 0;
    for (int i = 0; i < 100000; ++i) {
      const GuidedSample s = tree->Sample(0, synthetic::Unit2(rng));
      ASSERT_EQ(s.pdf, tree->Pdf(0, s.w));
      ASSERT_GT(s.pdf, 0);
      elsewhere += s.pdf != expected;
      ASSERT_NEAR(Length(s.w), 1, 1e-6);
    }
    EXPECT_EQ(elsewhere, 0);
  }
}

TEST(SdTree, CorruptBytesAreRefusedOrValid) {
  Training training;
  training.options.spatial_threshold = 1000;
  training.first_records = 2000;
  const auto tree = Train(training, 3);
  const Bytes bytes = tree->Serialize();
  for (size_t size = 0; size < bytes.size(); ++size)
    ASSERT_THROW(SdTree::Parse(std::string_view(bytes).substr(0, size)), Error) << size;
  EXPECT_THROW(SdTree::Parse(bytes + '\0'), Error);
  uint64_t rng = 8;
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Bytes changed = bytes;
    // Half of the flips in the head and the leaves.
    const size_t range = trial % 2 ? changed.size() : std::min<size_t>(changed.size(), 400);
    for (int flips = 1 + trial % 3; flips > 0; --flips)
      changed[static_cast<size_t>(synthetic::Unit(rng) * range)] ^= static_cast<char>(1 << (trial % 8));
    try {
      const auto parsed = SdTree::Parse(changed);
      ASSERT_EQ(parsed->Serialize(), changed);
      for (int i = 0; i < 20; ++i) {
        const uint32_t leaf = parsed->LeafAt(synthetic::Unit3(rng));
        const GuidedSample s = parsed->Sample(leaf, synthetic::Unit2(rng));
        ASSERT_TRUE(std::isfinite(s.pdf));
        ASSERT_EQ(s.pdf, parsed->Pdf(leaf, s.w));
      }
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::kCorrupt);
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(SdTree, BadBoundsAndSettingsAreRefused) {
  EXPECT_THROW(SdTree::Initial(Bounds3{}, SdTreeOptions{}), Error);
  EXPECT_THROW(SdTree::Initial({{0, 0, 0}, {kInfinity, 1, 1}}, SdTreeOptions{}), Error);
  EXPECT_THROW(SdTree::Initial({{0, 0, std::nanf("")}, {1, 1, 1}}, SdTreeOptions{}), Error);
  const auto refused = [](auto change) {
    SdTreeOptions options;
    change(options);
    EXPECT_THROW(SdTree::Initial(synthetic::UnitCube(), options), Error);
  };
  refused([](SdTreeOptions& o) { o.spatial_threshold = 0; });
  refused([](SdTreeOptions& o) { o.flux_threshold = std::nanf(""); });
  refused([](SdTreeOptions& o) { o.max_directional_depth = 21; });
  refused([](SdTreeOptions& o) { o.max_spatial_depth = 64; });
  refused([](SdTreeOptions& o) { o.initial_bsdf_fraction = 0; });
  refused([](SdTreeOptions& o) { o.max_nodes = 0; });
  // A point, a tiny and a far box have a tree.
  for (const Bounds3& box : {Bounds3{{1, 1, 1}, {1, 1, 1}}, Bounds3{{0, 0, 0}, {1e-4f, 1e-4f, 1e-5f}},
                             Bounds3{{1e6f, 1e6f, 1e6f}, {1.1e6f, 1.1e6f, 1e6f}}}) {
    const auto tree = SdTree::Initial(box, SdTreeOptions{});
    EXPECT_EQ(tree->LeafAt(box.Center()), 0u);
    EXPECT_FLOAT_EQ(tree->Pdf(0, {0, 0, 1}), kUniformSpherePdf);
    EXPECT_FALSE(tree->HasLearned(0));
  }
}

TEST(SdTree, SerialFormIsCanonical) {
  Training training;
  training.options.spatial_threshold = 1000;
  const auto tree = Train(training, 4);
  const Bytes bytes = tree->Serialize();
  const auto again = SdTree::Parse(bytes);
  EXPECT_EQ(again->fingerprint(), tree->fingerprint());
  EXPECT_EQ(again->Serialize(), bytes);
}

}  // namespace
}  // namespace lodestar
