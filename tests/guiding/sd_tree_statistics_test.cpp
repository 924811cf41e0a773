#include "core/guiding/sd_tree_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/math/sampler.h"
#include "tests/guiding/from_bytes.h"
#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

using SpatialFilter = SdTreeOptions::SpatialFilter;
using DirectionalFilter = SdTreeOptions::DirectionalFilter;

std::shared_ptr<const SdTree> SmallTree(SpatialFilter spatial = SpatialFilter::kStochastic,
                                        DirectionalFilter directional = DirectionalFilter::kBox) {
  synthetic::Training training;
  training.options.spatial_threshold = 1000;
  training.options.spatial_filter = spatial;
  training.options.directional_filter = directional;
  training.first_records = 5000;
  return synthetic::Train(training, 4);
}

void RecordOne(SdTreeStatistics& statistics, const SdTreeRecord& r, size_t index) {
  uint64_t rng = index;
  statistics.Record(r, synthetic::Unit3(rng));
}

double Total(const SdTreeStatistics& s) {
  double total = 0;
  for (uint32_t leaf = 0; leaf < s.tree()->leaf_count(); ++leaf) {
    for (const ExactSum& sum : s.slots(leaf)) total += sum.Value();
  }
  return total;
}

TEST(SdTreeStatistics, AnyPartitionGivesTheSameBits) {
  for (SpatialFilter filter : {SpatialFilter::kNearest, SpatialFilter::kStochastic, SpatialFilter::kBox}) {
    const auto tree = SmallTree(filter);
    auto records = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 9, 3000);
    SdTreeStatistics whole(tree);
    for (size_t i = 0; i < records.size(); ++i) RecordOne(whole, records[i], i);
    const Bytes expected = whole.Serialize();
    const Bytes advanced = Advance(*tree, whole, 32)->Serialize();

    std::mt19937 rng(6);
    for (int trial = 0; trial < 5; ++trial) {
      std::vector<size_t> order(records.size());
      for (size_t i = 0; i < order.size(); ++i) order[i] = i;
      std::shuffle(order.begin(), order.end(), rng);
      std::vector<std::unique_ptr<SdTreeStatistics>> parts;
      for (int p = 0; p < 7; ++p)
        parts.push_back(std::make_unique<SdTreeStatistics>(tree));  // unequal: the last stays empty
      for (size_t i : order) RecordOne(*parts[std::min<size_t>(rng() % 6, rng() % 6)], records[i], i);
      while (parts.size() > 1) {
        const size_t from = 1 + rng() % (parts.size() - 1), to = rng() % from;
        // Half of the parts travel.
        if (rng() % 2) {
          parts[to]->MergeSerialized(parts[from]->Serialize());
        } else {
          parts[to]->Merge(*parts[from]);
        }
        parts.erase(parts.begin() + static_cast<long>(from));
      }
      ASSERT_EQ(parts[0]->Serialize(), expected);
      ASSERT_EQ(Advance(*tree, *parts[0], 32)->Serialize(), advanced);
    }
  }
}

// Statistics take the pages of those before them: nothing of these may show.
TEST(SdTreeStatistics, LeaveNothingBehindInTheirPages) {
  SdTreeOptions options;
  options.spatial_threshold = 500;
  const auto tree = synthetic::Train({.options = options, .first_records = 50000}, 4);
  ASSERT_GT(tree->node_count(), 10000u) << "too small for pages to be kept";
  const Bytes empty = SdTreeStatistics(tree).Serialize();
  for (uint64_t seed = 0; seed < 3; ++seed) {
    SdTreeStatistics statistics(tree);
    EXPECT_EQ(statistics.Serialize(), empty) << seed;
    statistics.Record(synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, seed, 50000), seed);
    SdTreeStatistics moved = std::move(statistics);
    EXPECT_NE(moved.Serialize(), empty);
  }
}

TEST(SdTreeStatistics, EmptyMergesAreNeutral) {
  const auto tree = SmallTree();
  SdTreeStatistics empty(tree), one(tree);
  const auto records = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 1, 1);
  RecordOne(one, records[0], 0);
  const Bytes expected = one.Serialize(), nothing = empty.Serialize();
  one.Merge(empty);
  EXPECT_EQ(one.Serialize(), expected);
  EXPECT_EQ(empty.Serialize(), nothing);
  EXPECT_EQ(empty.touched_leaves(), 0u);
  empty.Merge(one);
  EXPECT_EQ(empty.Serialize(), expected);
  EXPECT_LT(nothing.size(), 80u);
}

TEST(SdTreeStatistics, FiltersConserveMassAndCount) {
  for (SpatialFilter spatial : {SpatialFilter::kNearest, SpatialFilter::kStochastic, SpatialFilter::kBox}) {
    for (DirectionalFilter directional : {DirectionalFilter::kNearest, DirectionalFilter::kBox}) {
      const auto tree = SmallTree(spatial, directional);
      const auto records = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 3, 2000);
      SdTreeStatistics statistics(tree);
      statistics.Record(records, 5);
      double expected = 0, weight = 0;
      for (const SdTreeRecord& r : records)
        expected += static_cast<double>(r.radiance) / r.pdf * tree->radiance_scale();
      for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf) weight += statistics.leaf(leaf).records();
      EXPECT_NEAR(Total(statistics) / expected, 1, 1e-5);
      EXPECT_NEAR(weight, 2000, 0.01);
      EXPECT_EQ(statistics.counts().accepted, 2000u);
    }
  }
}

// Reconstruction takes the halves for two samples of the same light: what one of them records may not lie elsewhere.
TEST(SdTreeStatistics, HalvesAreFilteredAlike) {
  synthetic::Training training;
  training.options.spatial_threshold = 1000;
  training.options.reconstruction = SdTreeOptions::Reconstruction::kNative;
  training.first_records = 5000;
  const auto tree = synthetic::Train(training, 4);
  SdTreeRecord r = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 3, 1)[0];
  r.position = {0.5f, 0.5f, 0.5f};  // the corner of many leaves
  r.leaf = tree->LeafAt(r.position);
  SdTreeStatistics statistics(tree);
  constexpr int kCount = 20000;
  for (uint64_t path = 0; path < kCount; ++path) statistics.Record(std::span(&r, 1), Mix64(path));
  uint64_t shared = 0;
  for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf) {
    double sums[2] = {0, 0};
    const std::span<const ExactSum> slots = statistics.slots(leaf);
    for (size_t i = 0; i < slots.size(); ++i) sums[i % 2] += slots[i].Value();
    const double both = sums[0] + sums[1], records = statistics.leaf(leaf).records();
    if (records < 100) continue;
    ++shared;
    // Each record is in one half or the other, by even odds.
    EXPECT_NEAR(sums[0] / both, 0.5, 5 * 0.5 / std::sqrt(records)) << leaf;
  }
  EXPECT_GT(shared, 3u);
}

// A sampler of the same key draws a path; what filters its records may not be those numbers over again.
TEST(SdTreeStatistics, TheFilterHasNumbersOfItsOwn) {
  const auto tree = SmallTree(SpatialFilter::kStochastic);
  SdTreeRecord r = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 3, 1)[0];
  r.position = {0.5f, 0.5f, 0.5f};
  r.leaf = tree->LeafAt(r.position);
  const std::vector<SdTreeRecord> path(8, r);
  // The last record of a long path stays in its leaf as often, whatever the path's numbers were.
  std::array<double, 2> stayed{}, count{};
  for (uint64_t i = 0; i < 4000; ++i) {
    Sampler sampler(1, 0, 0, 64, static_cast<uint32_t>(i));
    sampler.StartAt(6);  // the first that are hashes
    const size_t side = sampler.Next2D().x < 0.5f ? 0 : 1;
    SdTreeStatistics all(tree), but_last(tree);
    all.Record(path, sampler.key());
    but_last.Record(std::span(path).first(7), sampler.key());
    stayed[side] += all.leaf(r.leaf).records() - but_last.leaf(r.leaf).records();
    ++count[side];
  }
  const double a = stayed[0] / count[0], b = stayed[1] / count[1];
  EXPECT_NEAR(a, b, 5 * std::sqrt(0.25 / count[0] + 0.25 / count[1]));
}

TEST(SdTreeStatistics, StochasticHasTheExpectationOfTheBox) {
  const auto box_tree = SmallTree(SpatialFilter::kBox, DirectionalFilter::kNearest);
  Bytes bytes = box_tree->Serialize();
  ByteWriter from, to;
  box_tree->options().Write(from);
  SdTreeOptions options = box_tree->options();
  options.spatial_filter = SpatialFilter::kStochastic;
  options.Write(to);
  bytes.replace(8, from.bytes().size(), to.bytes());
  const auto stochastic_tree = SdTree::Parse(bytes);

  SdTreeRecord r = synthetic::MakeRecords(*box_tree, synthetic::MovingLobes, 1, 3, 1)[0];
  r.position = {0.5f, 0.5f, 0.5f};  // the corner of many leaves, far from the faces
  r.leaf = box_tree->LeafAt(r.position);
  SdTreeStatistics box(box_tree), stochastic(stochastic_tree);
  box.Record(r, {});
  constexpr int kCount = 200000;
  uint64_t rng = 1;
  for (int i = 0; i < kCount; ++i) stochastic.Record(r, synthetic::Unit3(rng));
  uint64_t shared = 0;
  for (uint32_t leaf = 0; leaf < box_tree->leaf_count(); ++leaf) {
    const double expected = box.leaf(leaf).records(), got = stochastic.leaf(leaf).records() / kCount;
    shared += expected > 0;
    EXPECT_NEAR(got, expected, 5 * std::sqrt(0.25 / kCount));
  }
  EXPECT_GT(shared, 3u);
}

TEST(SdTreeStatistics, BadRecordsAreRefusedAndCounted) {
  const auto tree = SmallTree();
  const SdTreeRecord good = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 3, 1)[0];
  SdTreeStatistics statistics(tree);
  int bad = 0;
  const auto record = [&](auto change) {
    SdTreeRecord r = good;
    change(r);
    statistics.Record(r, {});
    ++bad;
  };
  for (float v : {std::nanf(""), kInfinity, -1.0f}) {
    record([&](SdTreeRecord& r) { r.radiance = v; });
    record([&](SdTreeRecord& r) { r.pdf = v; });
    record([&](SdTreeRecord& r) { r.product = v; });
    record([&](SdTreeRecord& r) { r.bsdf_pdf = v; });
    record([&](SdTreeRecord& r) { r.tree_pdf = v; });
  }
  record([](SdTreeRecord& r) { r.pdf = 0; });
  record([](SdTreeRecord& r) { r.position.y = std::nanf(""); });
  record([](SdTreeRecord& r) { r.direction.z = kInfinity; });
  EXPECT_EQ(statistics.counts().refused, static_cast<uint64_t>(bad));
  EXPECT_EQ(statistics.touched_leaves(), 0u);
  SdTreeRecord delta = good;
  delta.delta = true;
  statistics.Record(delta, {});
  EXPECT_EQ(statistics.counts().delta, 1u);
  EXPECT_EQ(statistics.counts().accepted, 0u);
}

TEST(SdTreeStatistics, ExtremeValuesSaturateAndAreCounted) {
  const auto tree = SdTree::Initial(synthetic::UnitCube(), SdTreeOptions{});
  SdTreeStatistics statistics(tree);
  SdTreeRecord r;
  r.direction = {0, 0, 1};
  r.pdf = 1e-30f;
  r.radiance = 1e30f;
  statistics.Record(r, {0.5f, 0.5f, 0.5f});
  EXPECT_EQ(statistics.counts().saturated, 2u);  // the footprint at the pole: two cells
  const auto next = Advance(*tree, statistics, 4);
  EXPECT_TRUE(std::isfinite(next->Pdf(0, {0, 0, 1})));
}

TEST(SdTreeStatistics, TheWireIsSmall) {
  const auto tree = SmallTree();
  SdTreeStatistics statistics(tree);
  statistics.Record(synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 3, 20000), 5);
  size_t sums = 0;
  for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf)
    sums +=
        static_cast<size_t>(std::ranges::count_if(statistics.slots(leaf), [](const ExactSum& s) { return !s.zero(); }));
  EXPECT_LT(static_cast<double>(statistics.Serialize().size()), 7.5 * static_cast<double>(sums));
}

TEST(SdTreeStatistics, CorruptBytesAreRefusedOrValid) {
  const auto tree = SmallTree();
  SdTreeStatistics statistics(tree);
  statistics.Record(synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 3, 200), 5);
  const Bytes bytes = statistics.Serialize();
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THROW(test::FromBytes<SdTreeStatistics>(tree, std::string_view(bytes).substr(0, size)), Error) << size;
  }
  EXPECT_THROW(test::FromBytes<SdTreeStatistics>(tree, bytes + '\0'), Error);
  EXPECT_THROW(test::FromBytes<SdTreeStatistics>(SdTree::Initial(synthetic::UnitCube(), SdTreeOptions{}), bytes),
               Error);
  std::mt19937 rng(8);
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Bytes changed = bytes;
    for (int flips = 1 + static_cast<int>(rng() % 3); flips > 0; --flips)
      changed[rng() % changed.size()] ^= static_cast<char>(1 << (rng() % 8));
    try {
      const SdTreeStatistics parsed = test::FromBytes<SdTreeStatistics>(tree, changed);
      ASSERT_EQ(parsed.Serialize(), changed);  // canonical: what is accepted is what is written
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace lodestar
