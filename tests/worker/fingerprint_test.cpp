#include "worker/fingerprint.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <thread>

namespace lodestar {
namespace {

TEST(Fingerprint, IsTheSameAgainAndKnowsNeitherNameNorThreads) {
  EXPECT_EQ(DescribeWorker("a", 1).Fingerprint(), DescribeWorker("b", 8).Fingerprint());
}

TEST(Fingerprint, AnotherRoundingModeShows) {
  const WorkerInfo as_usual = DescribeWorker("a", 1);
  WorkerInfo upward;
  // On a thread of its own: the mode is the thread's.
  std::thread([&] {
    ASSERT_EQ(std::fesetround(FE_UPWARD), 0);
    upward = DescribeWorker("a", 1);
  }).join();
  EXPECT_EQ(as_usual.build_id, upward.build_id);
  EXPECT_NE(as_usual.canary, upward.canary);
}

}  // namespace
}  // namespace lodestar
