// A stop request ends rendering within 100 ms (core/tracing/tracer.h). The bound here is generous, for machines that
// are busy with other things; the figure itself is printed.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "tests/statistical/small_scenes.h"
#include "tests/support/render.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

// Milliseconds from the request to the executor's return, the longest of several; a round that would take minutes.
double LongestStop(uint32_t resolution, uint32_t passes, const char* method, int threads) {
  JobSpec job;
  job.method = method;
  job.max_depth = 100;
  job.resolution_x = job.resolution_y = resolution;
  const auto compiled = CompileJob(ParsePbrtText(test::kSmallScenes[0].text, "test.pbrt", "."), job);
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), threads);
  Round round = loop.NextRound();
  round.passes = passes;
  double longest = 0;
  for (int i = 0; i < 10; ++i) {
    StopToken stop;
    SteadyClock::time_point requested;
    std::jthread canceller([&] {
      std::this_thread::sleep_for(milliseconds(20 + 3 * i));
      requested = SteadyClock::now();
      stop.Request();
    });
    const bool whole = executor.Execute(loop.state(), round, stop).has_value();
    const auto returned = SteadyClock::now();
    canceller.join();
    EXPECT_FALSE(whole) << "the round was over before the request";
    longest = std::max(longest, std::chrono::duration<double, std::milli>(returned - requested).count());
  }
  return longest;
}

TEST(Stop, EndsTheWorkWithinATenthOfASecond) {
  struct Case {
    uint32_t resolution, passes;
    const char* method;
  };
  // A large picture; and the longest pixels that a round has, where a picture is small.
  for (const Case& c :
       {Case{1024, 64, "path"}, Case{1024, 64, "sdtree"}, Case{16, PassesPerRound(16, 16, false) * 64, "path"}}) {
    for (const int threads : {1, 2}) {
      const double longest = LongestStop(c.resolution, c.passes, c.method, threads);
      std::printf("%s %ux%u, %u passes, %d threads: stopped within %.1f ms\n", c.method, c.resolution, c.resolution,
                  c.passes, threads, longest);
      EXPECT_LT(longest, 1000) << c.method;
    }
  }
}

}  // namespace
}  // namespace lodestar
