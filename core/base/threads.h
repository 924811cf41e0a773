// How many threads this process should start.
#pragma once

namespace lodestar {

// Threads this process may use: affinity and the cgroup's CPU quota (rounded to whole CPUs) respected, at least 1.
int UsableThreads();

}  // namespace lodestar
