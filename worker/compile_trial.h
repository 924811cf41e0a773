// A scene is compiled in a process of its own first, under a limit of memory. One that takes all of it, or crashes the
// compiler, costs that process and a strike against its job, and not the worker with the other scenes that it holds.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/stop.h"
#include "rpc/work_types.h"

namespace lodestar {

class CompileTrial {
 public:
  struct Options {
    // lodestar-worker; its main() hands `PROGRAM kTrialWord FOLDER MIB` to RunTrial.
    std::filesystem::path program = "/proc/self/exe";
    uint64_t memory_bytes = 0;  // that a scene may take; 0: half of UsableMemory()
  };
  explicit CompileTrial(const Options& options);

  // Bytes that compiling the scene in `folder` took at most. Throws Error: the compiler's own about the scene; kIo,
  // naming the scene, where it needs more memory than allowed or the process died; kIo too where `stop` was requested.
  uint64_t Run(const JobDescription& description, const std::filesystem::path& folder, const StopToken& stop) const;
  uint64_t memory_bytes() const { return options_.memory_bytes; }

 private:
  Options options_;
};

inline constexpr const char* kTrialWord = "--compile-trial";
// The child's side. Returns its exit code.
int RunTrial(const std::string& folder, const std::string& memory_mib);

}  // namespace lodestar
