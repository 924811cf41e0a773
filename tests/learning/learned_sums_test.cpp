#include "core/learning/learned_sums.h"

#include <gtest/gtest.h>

#include "core/learning/focal_guiding.h"
#include "core/learning/grid_guiding.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

uint64_t Counted(const Statistics& statistics, HealthEvent event) {
  HealthReport health;
  statistics.AddHealth(&health);
  return health.counts[static_cast<size_t>(event)];
}

TEST(LearnedSums, WhatFocalGuidingRefusedIsInTheHealthReport) {
  const FocalMethod method(test::SyntheticJob("focal", 64), test::SyntheticSurvey());
  const auto statistics = method.NewStatistics(method.Initial());
  FocalStatistics& sums = dynamic_cast<FocalGuidingStatistics&>(*statistics).sums();
  FocalRecord record{.position = {0.5f, 0.5f, 0.5f}, .direction = {0, 0, 1}, .distance = 0.1f, .value = 1, .pdf = 1};
  sums.Record(record);
  EXPECT_EQ(Counted(*statistics, HealthEvent::kRefused), 0u);
  record.value = std::numeric_limits<float>::quiet_NaN();
  sums.Record(record);
  record.value = 3e38f;
  sums.Record(record);
  EXPECT_EQ(Counted(*statistics, HealthEvent::kRefused), 1u);
  EXPECT_EQ(Counted(*statistics, HealthEvent::kSaturated), sums.counts().saturated);
  EXPECT_GT(sums.counts().saturated, 0u);
}

TEST(LearnedSums, WhatGridGuidingRefusedIsInTheHealthReport) {
  const GridMethod method(test::SyntheticJob("grid", 64), test::SyntheticSurvey());
  const auto statistics = method.NewStatistics(method.Initial());
  GridStatistics& sums = dynamic_cast<GridGuidingStatistics&>(*statistics).sums();
  sums.Record(3, 5, 1);
  sums.Record(3, 5, -1);
  sums.Record(3, 5, kInfinity);
  sums.Record(3, 5, 3e38f);
  EXPECT_EQ(Counted(*statistics, HealthEvent::kRefused), 2u);
  EXPECT_EQ(Counted(*statistics, HealthEvent::kSaturated), 1u);
}

}  // namespace
}  // namespace lodestar
