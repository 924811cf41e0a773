// What Linux control groups leave this process of the machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

namespace lodestar {

struct CgroupLimits {
  double cpus = std::numeric_limits<double>::infinity();
  uint64_t memory_bytes = std::numeric_limits<uint64_t>::max();
};

// The least limits over the group of this process and the groups above it, as far as they can be seen: a service's
// quota stands in its own group, a container's often in one above. Versions 1 and 2. `root` holds proc/ and sys/.
CgroupLimits ReadCgroupLimits(const std::filesystem::path& root);

// Those of this process when it first asked.
const CgroupLimits& ProcessLimits();

}  // namespace lodestar
