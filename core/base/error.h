// The one exception type of the loading boundary: bad scenes, bad options, bad files, bad bytes from the network.
// The message says what was wrong, where, and what to try. Everything behind the boundary is checked data.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace lodestar {

enum class ErrorKind {
  kInvalidInput,  // the user's file or option is wrong
  kUnsupported,   // valid, but not implemented here
  kNotFound,      // a file or object is missing
  kCorrupt,       // bytes that do not decode, a wrong version or checksum
  kIo,            // the machine refused (disk full, permission)
  kConflict,      // valid, but not in this state (another scene's state file, a finished job)
};

class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, std::string message) : std::runtime_error(std::move(message)), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

}  // namespace lodestar
