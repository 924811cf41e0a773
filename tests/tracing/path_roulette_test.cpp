#include "core/tracing/path_roulette.h"

#include <gtest/gtest.h>

#include <limits>

namespace lodestar {
namespace {

TEST(PathRoulette, SurvivalFallsWithTheContributionBelowTheWindow) {
  const float expected = 3;
  EXPECT_FLOAT_EQ(SurvivalByContribution(kWindow * expected, expected), 1);
  EXPECT_GT(SurvivalByContribution(1.01f * kWindow * expected, expected), 1);
  EXPECT_FLOAT_EQ(SurvivalByContribution(0.6f * kWindow * expected, expected), 0.6f);
  // However little the tree expects, it may be wrong.
  EXPECT_EQ(SurvivalByContribution(0.9f * kLeastSurvival * kWindow * expected, expected), kLeastSurvival);
  EXPECT_EQ(SurvivalByContribution(0, expected), kLeastSurvival);
}

TEST(PathRoulette, SurvivalKnowsNoUnitOfLight) {
  for (const float contribution : {0.0f, 0.04f, 0.08f, 0.5f})
    for (const float unit : {0x1p-40f, 0x1p40f})
      EXPECT_EQ(SurvivalByContribution(unit * contribution, unit), SurvivalByContribution(contribution, 1));
}

TEST(PathRoulette, TheMeanWeightIsOne) {
  constexpr int kSteps = 1 << 16;
  for (const float survival : {1e-3f, kLeastSurvival, 0.5f, 0.77f, 0.999f, 1.0f, 5.0f}) {
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += RouletteWeight(survival, (static_cast<float>(i) + 0.5f) / kSteps);
    // One step more or less survives.
    EXPECT_NEAR(sum / kSteps, 1, 1.0 / (survival * kSteps)) << survival;
  }
}

TEST(PathRoulette, OnlyPathsAtStakeChange) {
  for (const float survival : {1.0f, 1.5f, std::numeric_limits<float>::infinity()})
    for (const float u : {0.0f, 0.5f, 0x1.fffffep-1f}) EXPECT_EQ(RouletteWeight(survival, u), 1) << survival;
  EXPECT_EQ(RouletteWeight(0.5f, 0.25f), 2);
  EXPECT_EQ(RouletteWeight(0.5f, 0.5f), 0);
  EXPECT_EQ(RouletteWeight(0, 0), 0);
}

}  // namespace
}  // namespace lodestar
