#include "core/base/memory.h"

#include <unistd.h>

#include <algorithm>

#include "core/base/cgroup.h"

namespace lodestar {

uint64_t UsableMemory() {
  const uint64_t bytes = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return std::min(bytes, ProcessLimits().memory_bytes);
}

}  // namespace lodestar
