// What holds of Advance() whatever the trees are proportional to and however they are reconstructed.
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "core/guiding/sd_tree_advance.h"
#include "tests/guiding/recorded_tree.h"

namespace lodestar {
namespace {

using Target = SdTreeOptions::Target;
using Reconstruction = SdTreeOptions::Reconstruction;
using synthetic::SameNodes;

class AdvanceByMethod : public testing::TestWithParam<std::tuple<Target, Reconstruction>> {
 protected:
  static SdTreeOptions Options() {
    SdTreeOptions options;
    std::tie(options.target, options.reconstruction) = GetParam();
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(
    All, AdvanceByMethod,
    testing::Combine(testing::Values(Target::kRadiance, Target::kSimple, Target::kFull, Target::kSwitching),
                     testing::Values(Reconstruction::kNone, Reconstruction::kDense, Reconstruction::kNative)));

directional::Tree Distribution(const SdTree& tree, uint32_t leaf = 0) {
  const DirectionalNode* const nodes = tree.Tree(leaf);
  return {{nodes, nodes + tree.leaf(leaf).node_count}, tree.leaf(leaf).depth};
}

// Of the first leaf: finite, nowhere negative, with an integral of 1, and positive where it is sampled.
void ExpectDensity(const SdTree& tree) {
  const directional::Tree distribution = Distribution(tree);
  double integral = 0;
  synthetic::ForEachCell(distribution, [&](uint32_t, uint32_t x, uint32_t y, int depth) {
    const int shift = directional::kBits - depth;
    const float density = directional::Locate(distribution.nodes.data(), x << shift, y << shift).density;
    ASSERT_TRUE(std::isfinite(density) && density >= 0) << density;
    integral += std::ldexp(density / kUniformSpherePdf, -2 * depth);
  });
  EXPECT_NEAR(integral, 1, 1e-5);
  uint64_t rng = 1;
  for (int i = 0; i < 200; ++i) {
    const GuidedSample s = tree.Sample(0, synthetic::Unit2(rng));
    ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0) << s.pdf;
    ASSERT_EQ(s.pdf, tree.Pdf(0, s.w));
  }
}

// Near the middle of a cell of the root.
Vec3 Axis() {
  return CylindricalToDirection({0.7f, 0.3f});
}

// A tree that has learned nothing, and one that has learned a lobe, deep enough for `dense`. One record is enough to
// learn from.
std::vector<std::shared_ptr<const SdTree>> Trees(const SdTreeOptions& options) {
  synthetic::Training training;
  training.options = options;
  training.options.spatial_threshold = 1e12f;
  training.options.min_records = 1;
  training.field = [](Vec3, Vec3 w) { return 0.02f + 100 * Exp(100 * (Dot(Axis(), w) - 1)) * (0.5f * kInvPi); };
  training.first_records = 4000;
  return {SdTree::Initial(synthetic::UnitCube(), training.options), synthetic::Train(training, 4)};
}

TEST_P(AdvanceByMethod, WhereNothingWasMetNothingIsLearned) {
  for (const auto& tree : Trees(Options())) {
    ASSERT_EQ(tree->leaf_count(), 1u);
    ASSERT_EQ(tree->HasLearned(0), tree->iteration() > 0);
    if (tree->HasLearned(0)) {
      ASSERT_GE(tree->leaf(0).depth, directional::kMinDenseDepth);
    }
    for (const size_t black : {size_t{0}, size_t{1}, size_t{500}}) {
      SCOPED_TRACE(std::to_string(tree->iteration()) + " iterations, " + std::to_string(black) + " records");
      SdTreeStatistics statistics(tree);
      statistics.Record(synthetic::MakeRecords(
                            *tree, [](Vec3, Vec3) { return 0.0f; }, 1, 7, black),
                        1);
      const auto next = Advance(*tree, statistics, 4);
      EXPECT_EQ(next->iteration(), tree->iteration() + 1);
      EXPECT_TRUE(SameNodes(Distribution(*next), Distribution(*tree)));
      EXPECT_EQ(next->HasLearned(0), tree->HasLearned(0));
      EXPECT_EQ(next->leaf(0).mean_flux, tree->leaf(0).mean_flux);
      EXPECT_EQ(next->leaf(0).records, static_cast<float>(black));
      EXPECT_EQ(next->BsdfFraction(0), tree->BsdfFraction(0));
      EXPECT_EQ(next->radiance_scale(), tree->radiance_scale());
      ExpectDensity(*next);
    }
  }
}

TEST_P(AdvanceByMethod, OneRecordIsEnough) {
  for (const auto& tree : Trees(Options())) {
    SCOPED_TRACE(std::to_string(tree->iteration()) + " iterations");
    SdTreeRecord r;
    r.position = {0.5f, 0.5f, 0.5f};
    r.direction = Axis();
    r.bsdf_pdf = kUniformSpherePdf;
    r.tree_pdf = tree->Pdf(0, r.direction);
    r.pdf = 0.5f * (r.bsdf_pdf + r.tree_pdf);
    r.radiance = 1;
    r.product = r.relative = kUniformSpherePdf;
    SdTreeStatistics statistics(tree);
    statistics.Record({&r, 1}, 1);
    const auto next = Advance(*tree, statistics, 4);
    EXPECT_TRUE(next->HasLearned(0));
    EXPECT_FLOAT_EQ(next->leaf(0).mean_flux, r.radiance / r.pdf);
    EXPECT_EQ(next->leaf(0).records, 1);
    // Against the 64 that the fraction so far counts as.
    EXPECT_NEAR(next->BsdfFraction(0), tree->BsdfFraction(0), 0.02);
    ExpectDensity(*next);
    // Of the root's cells this one has 0.81 of the record, or 0.56 by the roots of second moments: 3.2 or 2.25 times
    // the uniform density, of which `native` leaves 1.3 at least.
    EXPECT_GT(next->Pdf(0, r.direction), 1.2f * kUniformSpherePdf);
  }
}

// Light in another unit: a power of two commutes with every rounding but that of the first iteration's sums, whose unit
// is far below that of a node's probabilities.
TEST_P(AdvanceByMethod, RadianceTimesAPowerOfTwoLearnsTheSameBits) {
  synthetic::Training training;
  training.options = Options();
  training.options.spatial_threshold = 1000;
  training.first_records = 4000;
  constexpr int kIterations = 5;  // the last records what switching switches to
  const auto reference = synthetic::Train(training, kIterations);
  EXPECT_GT(reference->leaf_count(), 4u);
  for (const float scale : {0x1p-4f, 0x1p20f}) {
    SCOPED_TRACE(scale);
    training.scale = scale;
    const auto tree = synthetic::Train(training, kIterations);
    EXPECT_EQ(tree->radiance_scale() * scale, reference->radiance_scale());
    ASSERT_EQ(tree->leaf_count(), reference->leaf_count());
    for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf) {
      EXPECT_TRUE(SameNodes(Distribution(*tree, leaf), Distribution(*reference, leaf))) << leaf;
      EXPECT_EQ(tree->leaf(leaf).mean_flux, reference->leaf(leaf).mean_flux * scale) << leaf;
      EXPECT_EQ(tree->BsdfFraction(leaf), reference->BsdfFraction(leaf)) << leaf;
    }
  }
}

}  // namespace
}  // namespace lodestar
