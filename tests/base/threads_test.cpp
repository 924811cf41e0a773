#include "core/base/threads.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace lodestar {
namespace {

TEST(Threads, AffinityIsRespected) {
  int all = 0, pinned = 0;
  // On a thread of its own: affinity is the thread's.
  std::thread([&] {
    all = UsableThreads();
    cpu_set_t allowed, one;
    ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu) {
      if (CPU_ISSET(cpu, &allowed)) CPU_SET(cpu, &one);
    }
    EXPECT_LE(all, CPU_COUNT(&allowed));
    ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
    pinned = UsableThreads();
  }).join();
  EXPECT_GE(all, 1);
  EXPECT_EQ(pinned, 1);
}

}  // namespace
}  // namespace lodestar
