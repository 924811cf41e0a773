#include "client/exit_code.h"

namespace lodestar {

ExitCode ExitCodeOf(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInvalidInput:
    case ErrorKind::kUnsupported:
      return ExitCode::kUsage;
    case ErrorKind::kNotFound:
    case ErrorKind::kCorrupt:
    case ErrorKind::kIo:
      return ExitCode::kIo;
    case ErrorKind::kConflict:
      return ExitCode::kJobFailed;
  }
  return ExitCode::kInternal;
}

}  // namespace lodestar
