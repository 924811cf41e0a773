// How much memory this process should take.
#pragma once

#include <cstdint>

namespace lodestar {

// Bytes that this process may use: the machine's, or its cgroup's limit where that is less.
uint64_t UsableMemory();

}  // namespace lodestar
