#include "core/learning/loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "core/base/error.h"
#include "core/learning/auto_method.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

using test::Result;
using test::ResultOf;
using test::SyntheticExecutor;
using test::SyntheticJob;
using test::SyntheticSurvey;

struct Outcome {
  Result result;
  JobReport report;
  std::vector<Round> rounds;
};

Outcome RunJob(const JobSpec& job, SyntheticExecutor::Options options = {}, const Survey& survey = SyntheticSurvey()) {
  ManualClock clock;
  options.clock = &clock;
  Loop loop(job, survey);
  SyntheticExecutor executor(loop, options);
  loop.Run(executor, StopToken(), {}, clock);
  EXPECT_TRUE(loop.finished());
  return {ResultOf(loop), loop.Report(), executor.rounds};
}

// The same run by passes.
JobSpec ReplayOf(const JobReport& report) {
  JobSpec replay = report.job;
  replay.budget = {report.passes, 0, 0};
  replay.training_iterations = report.training_iterations;
  return replay;
}

std::vector<uint32_t> PassesOf(const std::vector<Round>& rounds) {
  std::vector<uint32_t> passes;
  for (const Round& round : rounds) passes.push_back(round.passes);
  return passes;
}

TEST(Loop, PathRoundsGrowAndAreOneIteration) {
  const Outcome run = RunJob(SyntheticJob("path", 200));
  EXPECT_EQ(PassesOf(run.rounds), (std::vector<uint32_t>{1, 1, 2, 4, 8, 16, 32, 64, 64, 8}));
  uint32_t at = 0;
  for (const Round& round : run.rounds) {
    EXPECT_EQ(round.iteration, 0u);
    EXPECT_EQ(round.first_pass, at);
    EXPECT_EQ(round.unit_count, 6u);
    EXPECT_FALSE(round.record);
    at += round.passes;
  }
  EXPECT_EQ(run.report.stop_reason, "spp");
  EXPECT_EQ(run.report.passes, 200u);
  EXPECT_EQ(run.report.training_iterations, 0);
  EXPECT_EQ(run.report.paths, 200u * 40 * 24);
}

TEST(Loop, IterationsDoubleAndTheLastTakesAtLeastHalf) {
  for (const uint64_t spp : {1, 2, 3, 4, 7, 15, 31, 64, 100, 127, 128, 255, 300}) {
    const Outcome run = RunJob(SyntheticJob("sdtree", spp));
    std::map<uint32_t, uint64_t> passes;
    for (const Round& round : run.rounds) {
      passes[round.iteration] += round.passes;
      EXPECT_EQ(round.record, round.iteration < static_cast<uint32_t>(run.report.training_iterations)) << spp;
    }
    EXPECT_EQ(run.report.passes, spp);
    EXPECT_EQ(run.report.iterations, passes.size());
    for (const auto& [iteration, count] : passes) {
      if (iteration + 1 < passes.size()) {
        EXPECT_EQ(count, uint64_t{1} << iteration) << spp;
      }
    }
    EXPECT_GE(2 * passes.rbegin()->second, spp) << spp;
    // And training is not given up early: it takes at least a tenth wherever the budget is more than a few passes.
    if (spp >= 10) {
      EXPECT_GE(10 * (spp - passes.rbegin()->second), spp) << spp;
    }
  }
}

TEST(Loop, IterationsThatGrowSlowlyLeaveHalfToTheLastToo) {
  for (const char* method : {"sdtree+focal", "focal"}) {
    for (const uint64_t spp : {12, 16, 75, 100}) {
      const Outcome run = RunJob(SyntheticJob(method, spp));
      uint64_t training = 0;
      for (const Round& round : run.rounds) training += round.record ? round.passes : 0;
      EXPECT_EQ(run.report.passes, spp);
      EXPECT_LE(2 * training, spp) << method << " " << spp;
      EXPECT_GE(4 * training, spp) << method << " " << spp;
    }
  }
}

TEST(Loop, LongIterationsAreCutIntoRounds) {
  JobSpec job = SyntheticJob("sdtree", 1000);
  job.training_iterations = 8;
  const Outcome run = RunJob(job);
  std::vector<uint32_t> expected{1, 2, 4, 8, 16, 32, 64, 64, 64};  // iteration 7 in two
  expected.insert(expected.end(), 11, 64);
  expected.push_back(41);
  EXPECT_EQ(PassesOf(run.rounds), expected);
  EXPECT_EQ(run.rounds[8].iteration, 7u);
  EXPECT_EQ(run.rounds[8].index, 1u);
}

TEST(Loop, SameBitsForAnyOrderPartitionAndDetour) {
  for (const char* method : {"path", "sdtree"}) {
    const JobSpec job = SyntheticJob(method, 60);
    const Outcome expected = RunJob(job);
    for (uint64_t seed = 1; seed <= 6; ++seed) {
      const Outcome run = RunJob(job, {.shuffle = seed, .detours = seed > 2});
      EXPECT_EQ(run.result, expected.result) << method << " " << seed;
    }
    JobSpec other = job;
    other.seed = 8;
    EXPECT_NE(RunJob(other).result.image, expected.result.image);  // the comparison can fail
  }
}

TEST(Loop, TheStateLearnsAndThenStays) {
  JobSpec job = SyntheticJob("sdtree", 20);
  job.training_iterations = 0;
  const Outcome untrained = RunJob(job);
  EXPECT_EQ(untrained.report.training_iterations, 0);
  EXPECT_EQ(untrained.report.iterations, 1u);
  EXPECT_EQ(untrained.result.state, Sha256(MakeMethod(job, SyntheticSurvey())->Initial()->Serialize()));
  job.training_iterations = 2;
  const Outcome trained = RunJob(job);
  EXPECT_NE(trained.result.state, untrained.result.state);
  EXPECT_EQ(trained.report.training_iterations, 2);
}

TEST(Loop, TheMethodsOptionFixesTraining) {
  JobSpec job = SyntheticJob("sdtree", 100);
  job.options["training"] = "2";
  EXPECT_EQ(RunJob(job).report.training_iterations, 2);
  job.training_iterations = 3;  // the job's comes first
  EXPECT_EQ(RunJob(job).report.training_iterations, 3);
}

// Steps are alike in passes, and none of them is lost to the image.
TEST(Loop, TheGridsStepsEnterTheImage) {
  const Survey survey = SyntheticSurvey(128, 128);
  for (const bool discard : {false, true}) {
    JobSpec job = SyntheticJob("grid", 192);
    if (discard) job.options["combine"] = "discard";
    Loop loop(job, survey);
    SyntheticExecutor executor(loop, {});
    loop.Run(executor, StopToken(), {});
    ASSERT_EQ(loop.Report().training_iterations, 6);  // of 8 passes
    const Image image = loop.Develop();
    double squares = 0;  // of relative errors
    for (uint32_t i = 0; i < image.size(); ++i) {
      const Rgb mean = test::SyntheticMean(i % image.width, i / image.width);
      squares += std::pow(image.pixels[i].g / mean.g - 1, 2) / static_cast<double>(image.size());
    }
    const double passes_that_count = 1 / (12 * squares);
    EXPECT_NEAR(passes_that_count, discard ? 144 : 192, 8);
  }
}

TEST(Loop, TimeBudgetIsMetWithinHalfARound) {
  for (const double seconds : {0.5, 3.0, 10.0, 47.0, 130.0, 200.5}) {
    JobSpec job = SyntheticJob("path", 0);
    job.budget.seconds = seconds;
    const Outcome run = RunJob(job, {.seconds_per_pass = 0.5});
    EXPECT_EQ(run.report.stop_reason, "time");
    const double last = run.rounds.back().passes * 0.5;
    EXPECT_LE(run.report.seconds - seconds, last / 2 + 0.5) << seconds;
    EXPECT_DOUBLE_EQ(run.report.seconds, static_cast<double>(run.report.passes) * 0.5);
  }
}

TEST(Loop, TimeBudgetLeavesHalfToTheLastIteration) {
  for (const double seconds : {20.0, 60.0, 100.0, 333.0}) {
    JobSpec job = SyntheticJob("sdtree", 0);
    job.budget.seconds = seconds;
    const Outcome run = RunJob(job, {.seconds_per_pass = 0.25});
    double training = 0;
    for (const Round& round : run.rounds) training += round.record ? round.passes * 0.25 : 0;
    EXPECT_LE(training, seconds / 2) << seconds;
    EXPECT_GE(training, seconds / 5) << seconds;
    EXPECT_NEAR(run.report.seconds, seconds, 8.1) << seconds;
    EXPECT_EQ(run.report.stop_reason, "time");
  }
}

// The loser of a race has two iterations, three passes in all. The winner trains for as long as if it had been forced.
TEST(Loop, WhatLosersTookIsNoTraining) {
  const Survey survey = SyntheticSurvey(80, 48);
  JobSpec forced = SyntheticJob("sdtree", 0), race = SyntheticJob("auto", 0);
  forced.budget.seconds = race.budget.seconds = 63;  // 31 passes of training, and 15 in the race but for that
  race.options["candidates"] = "sdtree,radiance";
  race.options["pilot"] = "1000";
  const Outcome alone = RunJob(forced, {}, survey), chosen = RunJob(race, {}, survey);
  EXPECT_EQ(alone.report.training_iterations, 5);
  EXPECT_EQ(chosen.report.training_iterations, 5 + 2);
  EXPECT_EQ(RunJob(ReplayOf(chosen.report), {.seconds_per_pass = 3}, survey).result, chosen.result);
}

TEST(Loop, ARunByTimeReplaysBySamples) {
  for (const char* method : {"path", "sdtree"}) {
    for (const double seconds : {0.1, 1.0, 5.0, 31.0, 64.0, 99.0}) {
      for (const char* combine : {"discard", "automatic", "inverse-variance"}) {
        JobSpec job = SyntheticJob(method, 0);
        if (job.method == "sdtree") job.options["combine"] = combine;
        job.budget.seconds = seconds;
        const Outcome run = RunJob(job, {.seconds_per_pass = 0.7});
        const Outcome again = RunJob(ReplayOf(run.report), {.shuffle = 3, .seconds_per_pass = 11});
        EXPECT_EQ(again.result, run.result) << method << " " << seconds << " " << combine;
        EXPECT_EQ(again.rounds, run.rounds);
      }
    }
  }
}

// In a picture this large the pilot of a tree has one film, and whether it is credited with more depends on what is
// left of the job: of one by time, on the clock.
TEST(Loop, AChoiceMadeByWhatWasLeftReplays) {
  const Survey survey = SyntheticSurvey(80, 48);
  JobSpec job = SyntheticJob("auto", 0);
  job.options["pilot"] = "1000";
  std::set<std::string> credits;
  for (const double seconds : {4.0, 9.0, 12.0, 31.0, 99.0}) {
    job.budget.seconds = seconds;
    const Outcome run = RunJob(job, {.seconds_per_pass = 0.7}, survey);
    const JobSpec replay = ReplayOf(run.report);
    credits.insert(replay.options.at("credit"));
    const Outcome again = RunJob(replay, {.shuffle = 3, .seconds_per_pass = 11}, survey);
    EXPECT_EQ(again.result, run.result) << seconds;
    EXPECT_EQ(again.rounds, run.rounds) << seconds;
  }
  EXPECT_GE(credits.size(), 3u);
  // It is the credit that makes the difference.
  job.budget = {100, 0, 0};
  job.training_iterations = 8;
  job.options["credit"] = "2";
  const Outcome none = RunJob(job, {}, survey);
  job.options["credit"] = "4";
  EXPECT_NE(RunJob(job, {}, survey).rounds, none.rounds);
}

TEST(Loop, LateIsWhereAnotherIterationEndsBeyondAQuarter) {
  const Survey survey = SyntheticSurvey(80, 48);
  for (const uint64_t spp : {8, 20, 36, 100, 300, 700}) {
    for (const bool by_time : {false, true}) {
      JobSpec job = SyntheticJob("auto", by_time ? 0 : spp);
      job.options["candidates"] = "sdtree,radiance";  // 1 and 2 passes each, and then more of one
      job.options["pilot"] = "1000";
      if (by_time) job.budget.seconds = static_cast<double>(spp);
      ManualClock clock;
      Loop loop(job, survey);
      SyntheticExecutor executor(loop, {.clock = &clock});
      // At each advance the passes so far; and the iterations until one was late.
      std::vector<uint64_t> ends;
      uint32_t late_from = AutoState::kNever;
      const auto advanced = [&](const std::shared_ptr<const State>&, const Statistics*,
                                const std::shared_ptr<const State>& next) {
        ends.push_back(loop.passes());
        late_from = std::min(late_from, dynamic_cast<const AutoState&>(*next).parts().late_from);
      };
      loop.Run(executor, StopToken(), {.advanced = advanced}, clock);
      ASSERT_FALSE(ends.empty());
      for (uint32_t k = 0; k + 1 < ends.size(); ++k) {
        // The first candidate's pilot is followed by the second's first pass, where its own third iteration is
        // expected.
        const uint64_t next = k == 1 ? ends[k] + 4 : ends[k + 1];
        EXPECT_EQ(k + 1 >= late_from, 4 * next > spp || late_from <= k) << spp << " " << by_time << " " << k;
      }
    }
  }
}

// A machine that becomes slow in the middle of training: the stop falls into a training iteration, and replays too.
TEST(Loop, AStopInTrainingReplays) {
  class SlowingExecutor final : public Executor {
   public:
    SlowingExecutor(const Loop& loop, ManualClock* clock) : inner_(loop, {}), clock_(clock) {}
    std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                        const StopToken& stop) override {
      clock_->Advance(std::chrono::seconds(round.iteration < 8 ? 1 : 600));
      return inner_.Execute(state, round, stop);
    }
    void Announce(const std::shared_ptr<const State>& state, const Round& next) override {
      inner_.Announce(state, next);
    }

   private:
    SyntheticExecutor inner_;
    ManualClock* clock_;
  };
  JobSpec job = SyntheticJob("sdtree", 0);
  job.budget.seconds = 1000;
  ManualClock clock;
  Loop loop(job, SyntheticSurvey());
  SlowingExecutor executor(loop, &clock);
  loop.Run(executor, StopToken(), {}, clock);
  const JobReport report = loop.Report();
  ASSERT_EQ(report.stop_reason, "time");
  ASSERT_EQ(report.training_iterations, static_cast<int>(report.iterations));
  EXPECT_EQ(RunJob(ReplayOf(report)).result, ResultOf(loop));
}

TEST(Loop, ErrorBudgetStopsOnceItIsMet) {
  // Relative variance of a pass: noise^2 / 12.
  for (const char* method : {"path", "sdtree"}) {
    JobSpec job = SyntheticJob(method, 0);
    job.budget.error = 0.0005;
    const Outcome run = RunJob(job, {.noise = 1});
    EXPECT_EQ(run.report.stop_reason, "error");
    EXPECT_LE(run.report.points.back().relmse_estimated, 0.0005);
    const double needed = 1 / 12.0 / 0.0005;
    EXPECT_GT(static_cast<double>(run.report.passes), needed * 0.9) << method;
    EXPECT_LT(static_cast<double>(run.report.passes), needed * 2.5 + 64) << method;
  }
  JobSpec job = SyntheticJob("sdtree", 0);
  job.budget.error = 0.001;
  const Outcome run = RunJob(job);
  EXPECT_EQ(RunJob(ReplayOf(run.report)).result, run.result);
}

TEST(Loop, NoBudgetMeansTheScenesSamples) {
  const Outcome run = RunJob(SyntheticJob("path", 0));
  EXPECT_EQ(run.report.passes, 12u);
  EXPECT_EQ(run.report.stop_reason, "spp");
}

TEST(Loop, TheFirstBudgetReachedEndsTheRun) {
  JobSpec job = SyntheticJob("path", 40);
  job.budget.seconds = 1000;
  job.budget.error = 1e-9;
  EXPECT_EQ(RunJob(job).report.stop_reason, "spp");
  job.budget.seconds = 10;
  EXPECT_EQ(RunJob(job).report.stop_reason, "time");
  job.budget.error = 0.5;
  job.budget.seconds = 1000;
  EXPECT_EQ(RunJob(job).report.stop_reason, "error");
}

TEST(Loop, AStoppedRunGoesOnWithTheSameBits) {
  const JobSpec job = SyntheticJob("sdtree", 60);
  const Outcome expected = RunJob(job);
  Loop loop(job, SyntheticSurvey());
  size_t executed = 0;
  for (int guard = 0; !loop.finished() && guard < 100; ++guard) {
    StopToken stop;
    SyntheticExecutor executor(loop, {.stop = &stop, .stop_before_round = 2});
    loop.Run(executor, stop, {});
    executed += executor.rounds.size();
    if (!loop.finished()) {
      EXPECT_EQ(loop.Report().stop_reason, "stopped");
    }
  }
  EXPECT_EQ(loop.Report().stop_reason, "spp");
  EXPECT_EQ(executed, expected.rounds.size());
  EXPECT_EQ(ResultOf(loop), expected.result);
}

TEST(Loop, AnExceptionLeavesTheLoopAtItsEdge) {
  class FailingExecutor final : public Executor {
   public:
    explicit FailingExecutor(const Loop& loop) : inner_(loop, {}) {}
    std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                        const StopToken& stop) override {
      if (++calls_ == 4) throw Error(ErrorKind::kIo, "the machine is on fire");
      return inner_.Execute(state, round, stop);
    }
    void Announce(const std::shared_ptr<const State>& state, const Round& next) override {
      inner_.Announce(state, next);
    }

   private:
    SyntheticExecutor inner_;
    int calls_ = 0;
  };
  const JobSpec job = SyntheticJob("path", 60);
  Loop loop(job, SyntheticSurvey());
  FailingExecutor failing(loop);
  EXPECT_THROW(loop.Run(failing, StopToken(), {}), Error);
  EXPECT_EQ(loop.passes(), 4u);
  SyntheticExecutor executor(loop, {});
  loop.Run(executor, StopToken(), {});
  EXPECT_EQ(ResultOf(loop), RunJob(job).result);
}

TEST(Loop, HooksAndMeasuringAreNotRenderTime) {
  ManualClock clock;
  const JobSpec job = SyntheticJob("sdtree", 60);
  Loop loop(job, SyntheticSurvey());
  SyntheticExecutor executor(loop, {.clock = &clock});
  int progressed = 0;
  double last_fraction = 0;
  Loop::Hooks hooks;
  hooks.progress = [&](const JobProgress& progress) {
    ++progressed;
    EXPECT_GE(progress.fraction, last_fraction);
    EXPECT_LE(progress.fraction, 1);
    last_fraction = progress.fraction;
    EXPECT_NEAR(progress.seconds_left, 60.0 - static_cast<double>(progress.passes), 1e-6);
    clock.Advance(std::chrono::hours(1));
  };
  uint32_t advanced = 0;
  hooks.advanced = [&](const std::shared_ptr<const State>& from, const Statistics* learned,
                       const std::shared_ptr<const State>& to) {
    ++advanced;
    EXPECT_TRUE(from == loop.state());
    EXPECT_TRUE(learned != nullptr);
    EXPECT_NE(Sha256(from->Serialize()), Sha256(to->Serialize()));
    clock.Advance(std::chrono::hours(1));
  };
  loop.Run(executor, StopToken(), hooks, clock);
  EXPECT_DOUBLE_EQ(loop.Report().seconds, 60);
  EXPECT_EQ(loop.Report().seconds_learning, 0);
  EXPECT_EQ(last_fraction, 1);
  EXPECT_EQ(progressed, static_cast<int>(executor.rounds.size()));
  EXPECT_GT(advanced, 0u);
  EXPECT_EQ(advanced, loop.Report().iterations - 1);
}

TEST(Loop, PointsAreThinnedAndKeepBothEnds) {
  Survey survey = SyntheticSurvey(4, 4);
  JobSpec job = SyntheticJob("path", 500000);
  job.budget.error = 1e-12;  // never met: measures densely enough to need the thinning
  const Outcome run = RunJob(job, {}, survey);
  const auto& points = run.report.points;
  EXPECT_LE(points.size(), 200u);
  EXPECT_GE(points.size(), 150u);
  EXPECT_EQ(points.front().spp, 1u);
  EXPECT_EQ(points.back().spp, 500000u);
  for (size_t i = 1; i < points.size(); ++i) {
    EXPECT_GT(points[i].spp, points[i - 1].spp);
    EXPECT_LE(static_cast<double>(points[i].spp), 2.01 * static_cast<double>(points[i - 1].spp));
  }
}

TEST(Loop, PointsFollowTheReference) {
  const JobSpec job = SyntheticJob("path", 256);
  Loop loop(job, SyntheticSurvey());
  SyntheticExecutor executor(loop, {});
  auto reference = std::make_shared<Image>();
  reference->width = 40;
  reference->height = 24;
  for (uint32_t y = 0; y < 24; ++y) {
    for (uint32_t x = 0; x < 40; ++x) reference->pixels.push_back(test::SyntheticMean(x, y));
  }
  loop.Run(executor, StopToken(), {.reference = reference});
  const JobReport report = loop.Report();
  EXPECT_EQ(report.points.front().relmse_estimated, std::numeric_limits<double>::infinity());  // one pass tells none
  for (const ErrorPoint& point : report.points) {
    ASSERT_TRUE(point.against_reference);
    const double expected = 1 / 12.0 / static_cast<double>(point.spp);
    EXPECT_NEAR(point.against_reference->relmse / expected, 1, 0.2) << point.spp;
    if (point.spp > 8) {
      EXPECT_NEAR(point.relmse_estimated / expected, 1, 0.12) << point.spp;
    }
  }
  reference->width = 24;
  reference->height = 40;
  Loop other(job, SyntheticSurvey());
  EXPECT_THROW(other.Run(executor, StopToken(), {.reference = reference}), Error);
  EXPECT_EQ(other.passes(), 0u);
}

TEST(Loop, AutomaticStopsWhenTheVarianceStopsFalling) {
  // The synthetic noise does not depend on the state, so training gains nothing and the rule must end it early.
  JobSpec job = SyntheticJob("sdtree", 4000);
  const int by_budget = RunJob(job, {}, SyntheticSurvey(16, 16)).report.training_iterations;
  job.options["combine"] = "automatic";
  const int automatic = RunJob(job, {}, SyntheticSurvey(16, 16)).report.training_iterations;
  EXPECT_LT(automatic, by_budget);
  EXPECT_GE(automatic, 4);
}

// Where iterations grow more slowly, more of them come before one tells its variance.
TEST(Loop, AutomaticJudgesNoIterationOfFewPasses) {
  JobSpec job = SyntheticJob("sdtree+focal", 4000);
  job.options["combine"] = "automatic";
  EXPECT_GE(RunJob(job, {}, SyntheticSurvey(16, 16)).report.training_iterations, 7);
}

TEST(Loop, ExtremeImages) {
  for (const auto& [width, height] : {std::pair<uint32_t, uint32_t>{1, 1}, {1, 700}, {700, 1}, {17, 16}}) {
    const Outcome run =
        RunJob(SyntheticJob("sdtree", 6), {.shuffle = 5, .detours = true}, SyntheticSurvey(width, height));
    EXPECT_EQ(run.report.passes, 6u);
  }
  const Outcome one_sample = RunJob(SyntheticJob("sdtree", 1), {}, SyntheticSurvey(1, 1));
  EXPECT_EQ(one_sample.report.passes, 1u);
  EXPECT_EQ(one_sample.report.training_iterations, 0);
}

TEST(Loop, JobsWithoutSenseAreRefused) {
  EXPECT_THROW(Loop(SyntheticJob("no such method", 1), SyntheticSurvey()), Error);
  EXPECT_THROW(Loop(SyntheticJob("path", 1), SyntheticSurvey(0, 5)), Error);
  EXPECT_THROW(Loop(SyntheticJob("path", 1), SyntheticSurvey(100000, 5)), Error);
  EXPECT_THROW(Loop(SyntheticJob("path", 1), SyntheticSurvey(60000, 60000)), Error);
  JobSpec negative = SyntheticJob("path", 1);
  negative.budget.seconds = -1;
  EXPECT_THROW(Loop(negative, SyntheticSurvey()), Error);
}

TEST(Loop, WhatTheMethodRefusedToLearnIsInTheHealthReport) {
  const JobSpec job = SyntheticJob("sdtree", 31);
  Loop loop(job, SyntheticSurvey());
  SyntheticExecutor executor(loop, {});
  loop.Run(executor, StopToken(), {});
  const auto training =
      std::count_if(executor.rounds.begin(), executor.rounds.end(), [](const Round& round) { return round.record; });
  ASSERT_GT(training, 1);
  const HealthReport health = loop.Report().health;
  EXPECT_EQ(health.counts[static_cast<size_t>(HealthEvent::kRefused)], static_cast<uint64_t>(training));
  EXPECT_EQ(health.counts[static_cast<size_t>(HealthEvent::kSaturated)], 0u);
}

}  // namespace
}  // namespace lodestar
