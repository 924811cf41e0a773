// Error <-> grpc::Status. The kind of an Error travels in the status's details, so that it survives codes that several
// kinds share.
#pragma once

#include <grpcpp/support/status.h>

#include <functional>

#include "core/base/error.h"

namespace lodestar {

// The peer could not be reached or did not answer in time: worth a retry where the call is idempotent.
class UnreachableError : public Error {
 public:
  explicit UnreachableError(const std::string& message) : Error(ErrorKind::kIo, message) {}
};
// The peer speaks another protocol version: no retry helps.
class ProtocolError : public Error {
 public:
  explicit ProtocolError(const std::string& message) : Error(ErrorKind::kConflict, message) {}
};
// The peer is out of some resource (a full queue, disk, message limit).
class ExhaustedError : public Error {
 public:
  explicit ExhaustedError(const std::string& message) : Error(ErrorKind::kIo, message) {}
};

grpc::Status ToStatus(const Error& error);
// Runs a handler's body; every exception becomes a status (one that is no Error: INTERNAL, logged).
grpc::Status Guarded(const std::function<void()>& body);
// Throws the Error that a status stands for; nothing where it is OK. `peer` is named in the message of an
// UnreachableError.
void ThrowIfFailed(const grpc::Status& status, const std::string& peer);

}  // namespace lodestar
