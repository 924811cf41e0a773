#include "core/base/cgroup.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;

// A machine as far as ReadCgroupLimits looks at it.
struct Cgroup : testing::Test {
  TemporaryFolder root;
  void In(const std::string& lines) { root.Write("proc/self/cgroup", lines); }
  void Set(const std::string& file, const std::string& text) { root.Write("sys/fs/cgroup/" + file, text + "\n"); }
  CgroupLimits Read() const { return ReadCgroupLimits(root.path()); }
};

TEST_F(Cgroup, WithoutLimitsThereAreNone) {
  EXPECT_EQ(Read().cpus, CgroupLimits().cpus) << "no control groups at all";
  In("0::/user.slice\n");
  Set("cpu.max", "max 100000");
  Set("user.slice/cpu.max", "max 100000");
  Set("user.slice/memory.max", "max");
  EXPECT_EQ(Read().cpus, CgroupLimits().cpus);
  EXPECT_EQ(Read().memory_bytes, CgroupLimits().memory_bytes);
}

TEST_F(Cgroup, AServicesOwnGroupCounts) {
  In("0::/system.slice/lodestar-worker.service\n");
  Set("system.slice/lodestar-worker.service/cpu.max", "150000 100000");
  Set("system.slice/lodestar-worker.service/memory.max", std::to_string(512 * kMiB));
  Set("other.service/cpu.max", "10000 100000");
  EXPECT_EQ(Read().cpus, 1.5);
  EXPECT_EQ(Read().memory_bytes, 512 * kMiB);
}

TEST_F(Cgroup, TheLeastOfAllLevelsCounts) {
  In("0::/a/b/c\n");
  Set("a/cpu.max", "200000 100000");
  Set("a/b/cpu.max", "max 100000");
  Set("a/b/c/cpu.max", "800000 100000");
  Set("a/memory.max", std::to_string(900 * kMiB));
  Set("a/b/memory.max", std::to_string(100 * kMiB));
  Set("a/b/c/memory.max", "max");
  EXPECT_EQ(Read().cpus, 2);
  EXPECT_EQ(Read().memory_bytes, 100 * kMiB);
}

TEST_F(Cgroup, AContainerThatSeesItsHostsPathFindsItsLimitsAtTheRoot) {
  In("0::/system.slice/docker-0123.scope\n");
  Set("cpu.max", "300000 100000");
  Set("memory.max", std::to_string(64 * kMiB));
  EXPECT_EQ(Read().cpus, 3);
  EXPECT_EQ(Read().memory_bytes, 64 * kMiB);
}

TEST_F(Cgroup, VersionOneHasATreeForEachController) {
  In("5:memory:/jobs/render\n4:cpu,cpuacct:/jobs\n3:cpuset:/\n0::/\n");
  Set("memory/memory.limit_in_bytes", "9223372036854771712");
  Set("memory/jobs/render/memory.limit_in_bytes", std::to_string(256 * kMiB));
  Set("cpu/cpu.cfs_quota_us", "-1");
  Set("cpu/cpu.cfs_period_us", "100000");
  Set("cpu/jobs/cpu.cfs_quota_us", "50000");
  Set("cpu/jobs/cpu.cfs_period_us", "100000");
  EXPECT_EQ(Read().cpus, 0.5);
  EXPECT_EQ(Read().memory_bytes, 256 * kMiB);
}

}  // namespace
}  // namespace lodestar
