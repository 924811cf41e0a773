#include "core/base/threads.h"

#include <sched.h>

#include <algorithm>
#include <cmath>

#include "core/base/cgroup.h"

namespace lodestar {

int UsableThreads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const double cpus = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
  return std::max(1, static_cast<int>(std::lround(std::min(cpus, ProcessLimits().cpus))));
}

}  // namespace lodestar
