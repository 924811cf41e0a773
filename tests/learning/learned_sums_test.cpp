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

// As new, and nothing of what was there shows in what comes next.
void ExpectCleared(const Method& method, Statistics* statistics) {
  const Bytes full = statistics->Serialize(), empty = method.NewStatistics(method.Initial())->Serialize();
  ASSERT_NE(full, empty);
  statistics->Clear();
  EXPECT_EQ(statistics->Serialize(), empty);
  statistics->MergeSerialized(full);
  EXPECT_EQ(statistics->Serialize(), full);
}

TEST(LearnedSums, AreAsNewWhenCleared) {
  const FocalMethod focal(test::SyntheticJob("focal", 64), test::SyntheticSurvey());
  auto statistics = focal.NewStatistics(focal.Initial());
  dynamic_cast<FocalGuidingStatistics&>(*statistics)
      .sums()
      .Record({.position = {0.5f, 0.5f, 0.5f}, .direction = {0, 0, 1}, .distance = 0.1f, .value = 1, .pdf = 1});
  ExpectCleared(focal, statistics.get());

  const GridMethod grid(test::SyntheticJob("grid", 64), test::SyntheticSurvey());
  statistics = grid.NewStatistics(grid.Initial());
  dynamic_cast<GridGuidingStatistics&>(*statistics).sums().Record(3, 5, 1);
  ExpectCleared(grid, statistics.get());

  const JobSpec job = test::SyntheticJob("sdtree", 8);
  const Survey survey = test::SyntheticSurvey();
  const auto sdtree = MakeMethod(job, survey);
  const TileGrid tiles(survey.resolution_x, survey.resolution_y);
  Contribution unit =
      test::RenderUnit(job, *sdtree, sdtree->Initial(), tiles, {1, 0, 1, 2, tiles.tile_count(), true}, 0);
  ExpectCleared(*sdtree, unit.statistics.get());
}

}  // namespace
}  // namespace lodestar
