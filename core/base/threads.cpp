#include "core/base/threads.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

namespace lodestar {
namespace {

// Whole CPUs of the cgroup's quota, or nothing where there is none (cgroup v2, then v1).
std::optional<int> CgroupCpus() {
  const auto cpus = [](double quota, double period) { return std::max(1, static_cast<int>(quota / period + 0.5)); };
  if (std::ifstream v2("/sys/fs/cgroup/cpu.max"); v2) {
    std::string quota;
    double period = 0;
    if (v2 >> quota >> period && quota != "max" && period > 0) return cpus(std::stod(quota), period);
    return std::nullopt;
  }
  std::ifstream quota_file("/sys/fs/cgroup/cpu/cpu.cfs_quota_us"), period_file("/sys/fs/cgroup/cpu/cpu.cfs_period_us");
  double quota = 0, period = 0;
  if (quota_file >> quota && period_file >> period && quota > 0 && period > 0) return cpus(quota, period);
  return std::nullopt;
}

}  // namespace

int UsableThreads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  int threads = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
  if (const auto quota = CgroupCpus()) threads = std::min(threads, *quota);
  return std::max(threads, 1);
}

}  // namespace lodestar
