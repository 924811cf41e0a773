// How a command ends. The codes are part of the interface (docs/command-line.md): scripts branch on them.
#pragma once

#include <stdexcept>
#include <string>

#include "core/base/error.h"

namespace lodestar {

enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,         // a fault of ours
  kUsage = 2,            // an option or its value is wrong
  kBadScene = 3,         // the scene, or a file it names, is missing, malformed or unsupported
  kIo = 4,               // another file, or standard output, could not be read or written
  kFarmUnreachable = 5,  // no answer from the coordinator
  kJobFailed = 6,        // the farm refused the job, or it failed or was cancelled
  kInterrupted = 130,    // Ctrl-C; what was rendered so far has been written
};

// Ends a command with a code of its choice; everything else that is thrown gets its code from ExitCodeOf.
class CommandError : public std::runtime_error {
 public:
  CommandError(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

ExitCode ExitCodeOf(ErrorKind kind);

}  // namespace lodestar
