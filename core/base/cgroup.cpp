#include "core/base/cgroup.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace lodestar {
namespace {

namespace fs = std::filesystem;

// The first numbers of a file; 0 for each that is missing, and for "max".
struct Numbers {
  double first = 0, second = 0;
  explicit Numbers(const fs::path& file) { std::ifstream(file) >> first >> second; }
};

void LowerCpus(double quota, double period, CgroupLimits* limits) {
  if (quota > 0 && period > 0) limits->cpus = std::min(limits->cpus, quota / period);
}

void LowerMemory(const fs::path& file, CgroupLimits* limits) {
  uint64_t bytes = 0;
  if (std::ifstream(file) >> bytes && bytes > 0) limits->memory_bytes = std::min(limits->memory_bytes, bytes);
}

// Calls `read` with the folder of `group` below `mount` and of each group above it. A container may see the path of
// its host here and its own group as the root of the mount, so folders that are not there say nothing.
template <class Read>
void Upwards(const fs::path& mount, fs::path group, const Read& read) {
  for (; group.has_relative_path(); group = group.parent_path()) read(mount / group.relative_path());
  read(mount);
}

}  // namespace

CgroupLimits ReadCgroupLimits(const fs::path& root) {
  CgroupLimits limits;
  const fs::path mount = root / "sys/fs/cgroup";
  std::ifstream groups(root / "proc/self/cgroup");
  // ID:CONTROLLERS:PATH. No controllers: version 2, where one tree has them all; else one tree each.
  for (std::string line; std::getline(groups, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path group = line.substr(second + 1);
    if (controllers == ",,") {
      Upwards(mount, group, [&](const fs::path& folder) {
        const Numbers max(folder / "cpu.max");
        LowerCpus(max.first, max.second, &limits);
        LowerMemory(folder / "memory.max", &limits);
      });
    }
    if (controllers.find(",cpu,") != std::string::npos) {
      Upwards(mount / "cpu", group, [&](const fs::path& folder) {
        LowerCpus(Numbers(folder / "cpu.cfs_quota_us").first, Numbers(folder / "cpu.cfs_period_us").first, &limits);
      });
    }
    if (controllers.find(",memory,") != std::string::npos) {
      Upwards(mount / "memory", group,
              [&](const fs::path& folder) { LowerMemory(folder / "memory.limit_in_bytes", &limits); });
    }
  }
  return limits;
}

const CgroupLimits& ProcessLimits() {
  static const CgroupLimits limits = ReadCgroupLimits("/");
  return limits;
}

}  // namespace lodestar
