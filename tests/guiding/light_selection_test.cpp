#include "core/guiding/light_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

constexpr uint32_t kGroups = 8, kVisible = 5;
const std::vector<float> kPower = {0.3f, 0.1f, 0.1f, 0.1f, 0.1f, 0.02f, 0.08f, 0.2f};

// Light samples by the state's own choice: group kVisible arrives where x < 0.5, group 0 elsewhere; all have twice the
// mean at even odds.
void RecordLights(SdTreeStatistics& statistics, uint64_t seed, int count, int part = 0, int parts = 1) {
  uint64_t rng = Mix64(seed);
  for (int i = 0; i < count; ++i) {
    const Vec3 p = synthetic::Unit3(rng);
    const uint32_t leaf = statistics.tree()->LeafAt(p);
    const std::span<const uint16_t> lights = statistics.tree()->Lights(leaf);
    const float u = synthetic::Unit(rng) * 65536, bright = synthetic::Unit(rng) < 0.5f ? 2.0f : 0.0f;
    uint8_t group = 0;
    for (float end = lights[0]; u >= end; end += lights[++group]) {
    }
    if (i % parts != part) continue;
    const float probability = static_cast<float>(lights[group]) * 0x1p-16f;
    statistics.Record(SdTreeRecord{.position = p,
                                   .direction = {0, 0, 1},
                                   .radiance = 1,
                                   .pdf = 1,
                                   .bsdf_pdf = 1,
                                   .tree_pdf = 1,
                                   .product = 1,
                                   .leaf = leaf},
                      {0.5f, 0.5f, 0.5f});
    if (group == (p.x < 0.5f ? kVisible : 0) && bright > 0)
      statistics.Record(LightRecord{bright / probability, probability, leaf, group});
  }
}

SdTreeOptions Options() {
  SdTreeOptions options;
  options.spatial_threshold = 3000;
  options.spatial_filter = SdTreeOptions::SpatialFilter::kNearest;
  return options;
}

std::shared_ptr<const SdTree> Trained(int iterations) {
  auto tree = SdTree::Initial(synthetic::UnitCube(), Options(), kPower);
  for (int k = 0; k < iterations; ++k) {
    SdTreeStatistics statistics(tree);
    RecordLights(statistics, static_cast<uint64_t>(k), 20000);
    tree = Advance(*tree, statistics, 4);
  }
  return tree;
}

TEST(LightSelection, FindsTheOneVisibleLightOfEight) {
  const auto tree = Trained(3);
  EXPECT_GT(tree->leaf_count(), 4u);
  for (const bool left : {true, false}) {
    const uint32_t leaf = tree->LeafAt({left ? 0.1f : 0.9f, 0.5f, 0.5f}), visible = left ? kVisible : 0;
    const auto lights = tree->Lights(leaf);
    EXPECT_NEAR(lights[visible] * 0x1p-16, 1 - kLightsByPower + kLightsByPower * kPower[visible], 2e-3);
    for (uint32_t g = 0; g < kGroups; ++g) EXPECT_GE(lights[g] * 0x1p-16, 0.999 * kLightsByPower * kPower[g] - 1e-4);
    EXPECT_EQ(std::accumulate(lights.begin(), lights.end(), 0u), 65536u);
  }
}

TEST(LightSelection, HasTheRootsOfTheSecondMoments) {
  // Two visible groups of means 1 and 3, whatever was used to sample them.
  for (const double used : {0.2, 0.5, 0.9}) {
    std::vector<ExactSum> sums(2);
    uint64_t rng = 4;
    for (int i = 0; i < 200000; ++i) {
      const bool second = synthetic::Unit(rng) >= used;
      const double p = second ? 1 - used : used, d = (second ? 3 : 1) / p;
      sums[second].Add(static_cast<float>(d * d * p));
    }
    const std::vector<uint16_t> power = {32768, 32768};
    const auto next = SolveLightSelection(sums, power, power);
    EXPECT_NEAR(next[1] * 0x1p-16, 0.75 * (1 - kLightsByPower) + 0.5 * kLightsByPower, 0.005) << used;
  }
}

TEST(LightSelection, IteratedUnderMisItHasTheLeastSecondMoment) {
  // Constant integrands a_g on unit domains, light density P_g, directional density b_g: d = a / (P + b) by the balance
  // heuristic. The second moment, sum of a^2 / (P + b), is least where d is the same for both.
  const double a[2] = {1, 2}, b[2] = {0.1, 2};
  const double least = (a[0] * (1 + b[1]) - a[1] * b[0]) / (a[0] + a[1]);
  const std::vector<uint16_t> power = {16384, 49152};
  double p = 0.5;  // of the first group, without the share by power
  for (int i = 0; i < 200; ++i) {
    const double probability[2] = {p, 1 - p};
    std::vector<ExactSum> sums(2);
    for (size_t g = 0; g < 2; ++g) {
      const double d = a[g] / (probability[g] + b[g]);
      // d^2 P_g for each sample, and P_g of the samples are the group's.
      sums[g].Add(static_cast<float>(d * d * probability[g] * probability[g]));
    }
    const auto next = SolveLightSelection(sums, power, power);
    p = 0x1p-16 * (next[0] - kLightsByPower * power[0]) / (1 - kLightsByPower);
  }
  EXPECT_NEAR(p, least, 2e-3);  // units of 2^-16, ten times as far apart where the iteration stands still
}

TEST(LightSelection, KeepsWhatItHasWithoutRecords) {
  const auto tree = Trained(2);
  const uint32_t leaf = tree->LeafAt({0.1f, 0.5f, 0.5f});
  SdTreeStatistics few(tree);
  RecordLights(few, 3, 100);
  for (const auto& next : {Advance(*tree, few, 4), Advance(*tree, SdTreeStatistics(tree), 4)}) {
    ASSERT_EQ(next->leaf_count(), tree->leaf_count());
    EXPECT_TRUE(std::ranges::equal(next->Lights(leaf), tree->Lights(leaf)));
  }
  const std::vector<ExactSum> nothing(kGroups);
  const auto power = tree->lights_by_power();
  EXPECT_TRUE(std::ranges::equal(SolveLightSelection(nothing, power, tree->Lights(leaf)), tree->Lights(leaf)));
}

TEST(LightSelection, MergesExactlyAndTravels) {
  const auto tree = Trained(2);
  SdTreeStatistics whole(tree), merged(tree);
  RecordLights(whole, 8, 5000);
  for (int part = 2; part >= 0; --part) {
    SdTreeStatistics one(tree);
    RecordLights(one, 8, 5000, part, 3);
    merged.MergeSerialized(one.Serialize());
  }
  EXPECT_EQ(merged.Serialize(), whole.Serialize());
  const Bytes state = Advance(*tree, merged, 4)->Serialize();
  EXPECT_EQ(SdTree::Parse(state)->Serialize(), state);
  EXPECT_TRUE(SdTree::Parse(state)->fingerprint() == Advance(*tree, whole, 4)->fingerprint());
}

TEST(LightSelection, DamageIsRefusedOrADistribution) {
  const Bytes bytes = Trained(1)->Serialize();
  std::mt19937 rng(8);
  for (int trial = 0; trial < 2000; ++trial) {
    Bytes changed = bytes;
    changed[changed.size() - 1 - rng() % 60] ^= static_cast<char>(1 << (rng() % 8));
    EXPECT_THROW(SdTree::Parse(changed), Error);  // a sum of 2^16 does not survive one bit
  }
}

TEST(LightSelection, CostsNothingWhereThereIsNoChoice) {
  const std::vector<float> one = {1};
  const auto tree = SdTree::Initial(synthetic::UnitCube(), Options(), one),
             plain = SdTree::Initial(synthetic::UnitCube(), Options());
  EXPECT_TRUE(tree->Lights(0).empty());
  EXPECT_EQ(tree->Serialize(), plain->Serialize());
  EXPECT_TRUE(SdTreeStatistics(tree).lights(0).empty());
}

TEST(LightSelection, ExtremeRecordsStayFinite) {
  const auto tree = SdTree::Initial(synthetic::UnitCube(), Options(), kPower);
  SdTreeStatistics statistics(tree);
  for (const float d : {1e30f, 3e38f, 1e-30f, std::nanf(""), kInfinity, -1.0f, 0.0f})
    statistics.Record(LightRecord{d, 1e-3f, 0, 2});
  const auto next = SolveLightSelection(statistics.lights(0), tree->lights_by_power(), tree->Lights(0));
  EXPECT_EQ(std::accumulate(next.begin(), next.end(), 0u), 65536u);
  EXPECT_GT(next[2], 40000);
}

TEST(LightSelection, SharesAreQuantizedWithoutLosingAny) {
  for (const std::vector<double>& shares :
       {std::vector<double>{1, 0}, {1e-12, 1}, {0.5, 0.5}, std::vector<double>(32, 1.0 / 32)}) {
    const auto units = QuantizeShares(shares);
    EXPECT_EQ(std::accumulate(units.begin(), units.end(), 0u), 65536u);
    for (size_t g = 0; g < units.size(); ++g) {
      EXPECT_GE(units[g], 1);
      EXPECT_NEAR(units[g], 65536 * shares[g], 32);
    }
  }
}

}  // namespace
}  // namespace lodestar
