#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/learning/loop.h"
#include "tests/learning/synthetic.h"
#include "tests/support/resealed.h"

namespace lodestar {
namespace {

using test::ResultOf;
using test::SyntheticExecutor;
using test::SyntheticJob;
using test::SyntheticSurvey;

JobSpec JobOf(const std::string& method, const std::string& combine) {
  JobSpec job = SyntheticJob(method, 0);
  if (method == "sdtree") job.options["combine"] = combine;
  if (method == "focal") job.options["passes"] = "4";  // of an iteration, so that the budget is enough for all
  job.budget.seconds = 80;
  return job;
}

// Every checkpoint of a run, each at another place: mid-iteration, before and after an advance, at the end.
std::vector<Bytes> CheckpointsOf(const JobSpec& job, test::Result* result) {
  ManualClock clock;
  Loop loop(job, SyntheticSurvey());
  std::vector<Bytes> checkpoints;
  const auto take = [&] {
    Bytes here = loop.Checkpoint();
    if (checkpoints.empty() || checkpoints.back() != here) checkpoints.push_back(std::move(here));
  };
  SyntheticExecutor executor(loop, {.clock = &clock, .before_round = take});
  loop.Run(executor, StopToken(), {.progress = [&](const JobProgress&) { take(); }}, clock);
  *result = ResultOf(loop);
  return checkpoints;
}

TEST(Checkpoint, RestoredAnywhereGivesTheSameBits) {
  for (const auto& [method, combine] : std::map<std::string, std::string>{
           {"path", ""}, {"sdtree", "inverse-variance"}, {"focal", ""}, {"grid", ""}, {"sdtree+focal", ""}}) {
    test::Result expected;
    const std::vector<Bytes> checkpoints = CheckpointsOf(JobOf(method, combine), &expected);
    ASSERT_GT(checkpoints.size(), 6u);
    for (size_t i = 0; i < checkpoints.size(); ++i) {
      const auto loop = Loop::Restore(checkpoints[i]);
      EXPECT_TRUE(loop->Checkpoint() == checkpoints[i]) << i;
      ManualClock clock;
      SyntheticExecutor executor(*loop, {.shuffle = i, .clock = &clock});
      loop->Run(executor, StopToken(), {}, clock);
      EXPECT_EQ(ResultOf(*loop), expected) << method << " " << i;
      EXPECT_TRUE(loop->Checkpoint() == checkpoints.back()) << i;  // times, points and decisions too
    }
  }
}

TEST(Checkpoint, OtherCombinationsToo) {
  for (const char* combine : {"discard", "automatic"}) {
    test::Result expected;
    const std::vector<Bytes> checkpoints = CheckpointsOf(JobOf("sdtree", combine), &expected);
    for (size_t i = 0; i < checkpoints.size(); i += 3) {
      const auto loop = Loop::Restore(checkpoints[i]);
      ManualClock clock;
      SyntheticExecutor executor(*loop, {.clock = &clock});
      loop->Run(executor, StopToken(), {}, clock);
      EXPECT_EQ(ResultOf(*loop), expected) << combine << " " << i;
    }
  }
}

TEST(Checkpoint, AFinishedLoopStaysFinished) {
  test::Result expected;
  const auto loop = Loop::Restore(CheckpointsOf(JobOf("path", ""), &expected).back());
  EXPECT_TRUE(loop->finished());
  EXPECT_EQ(loop->Report().stop_reason, "time");
  SyntheticExecutor executor(*loop, {});
  loop->Run(executor, StopToken(), {});
  EXPECT_TRUE(executor.rounds.empty());
  EXPECT_EQ(ResultOf(*loop), expected);
}

TEST(Checkpoint, DamageIsRefused) {
  test::Result unused;
  const Bytes bytes = CheckpointsOf(JobOf("sdtree", "discard"), &unused)[5];
  const size_t step = bytes.size() / 300 + 1;
  for (size_t size = 0; size < bytes.size(); size += step)
    EXPECT_THROW(Loop::Restore(std::string_view(bytes).substr(0, size)), Error) << size;
  for (size_t i = 0; i < bytes.size(); i += i < 100 ? 1 : step) {
    Bytes damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    EXPECT_THROW(Loop::Restore(damaged), Error) << i;
  }
  EXPECT_THROW(Loop::Restore(""), Error);
  EXPECT_THROW(Loop::Restore(JobOf("path", "").Serialize()), Error);
}

// A right checksum around wrong content: no crash, whatever the content says.
TEST(Checkpoint, ForgedContentDoesNotCrash) {
  test::Result unused;
  const std::vector<Bytes> checkpoints = CheckpointsOf(JobOf("sdtree", "inverse-variance"), &unused);
  const Bytes& bytes = checkpoints[7];
  test::Random random(5);
  int refused = 0, read = 0;
  for (int i = 0; i < 400; ++i) {
    // Most of the bytes are film sums, where a change is a value like another; the rest is what matters here.
    const size_t at = 8 + random.Next() % (i % 2 == 0 ? 1500 : bytes.size() - 16);
    const Bytes forged = Resealed(
        bytes, [&](Bytes* content) { (*content)[(at - 8) % content->size()] = static_cast<char>(random.Next()); });
    try {
      const auto loop = Loop::Restore(forged);
      if (!loop->finished()) loop->NextRound();
      loop->Develop();
      ++read;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(read, 50);
}

// A method that chooses looks its candidates up by their numbers.
TEST(Checkpoint, AFilmOfNoCandidateIsRefused) {
  Loop loop(SyntheticJob("auto", 0), SyntheticSurvey());
  const Bytes bytes = loop.Checkpoint(), state = loop.state()->Serialize();
  // After the state: the position (four counts, five flags and six times), the number of films, the first one's
  // iteration.
  const Bytes forged =
      Resealed(bytes, [&](Bytes* content) { (*content)[content->find(state) + state.size() + 77 + 8 + 4] = 9; });
  try {
    Loop::Restore(forged);
    FAIL() << "was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("film of no candidate"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lodestar
