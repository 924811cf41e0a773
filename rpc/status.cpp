#include "rpc/status.h"

#include "core/base/log.h"

namespace lodestar {
namespace {

constexpr const char* kKinds[] = {"invalid_input", "unsupported", "not_found", "corrupt", "io", "conflict"};

grpc::StatusCode Code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInvalidInput:
      return grpc::StatusCode::INVALID_ARGUMENT;
    case ErrorKind::kUnsupported:
      return grpc::StatusCode::INVALID_ARGUMENT;
    case ErrorKind::kNotFound:
      return grpc::StatusCode::NOT_FOUND;
    case ErrorKind::kCorrupt:
      return grpc::StatusCode::DATA_LOSS;
    case ErrorKind::kIo:
      return grpc::StatusCode::INTERNAL;
    case ErrorKind::kConflict:
      return grpc::StatusCode::FAILED_PRECONDITION;
  }
  return grpc::StatusCode::INTERNAL;
}

}  // namespace

grpc::Status ToStatus(const Error& error) {
  if (dynamic_cast<const ProtocolError*>(&error))
    return {grpc::StatusCode::FAILED_PRECONDITION, error.what(), "protocol"};
  if (dynamic_cast<const ExhaustedError*>(&error)) return {grpc::StatusCode::RESOURCE_EXHAUSTED, error.what(), "io"};
  if (dynamic_cast<const UnreachableError*>(&error)) return {grpc::StatusCode::UNAVAILABLE, error.what(), "io"};
  return {Code(error.kind()), error.what(), kKinds[static_cast<int>(error.kind())]};
}

grpc::Status Guarded(const std::function<void()>& body) {
  try {
    body();
    return grpc::Status::OK;
  } catch (const Error& error) {
    return ToStatus(error);
  } catch (const std::bad_alloc&) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED, "out of memory", "io"};
  } catch (const std::exception& error) {
    spdlog::error("a call failed in a way that is a bug: {}", error.what());
    return {grpc::StatusCode::INTERNAL, std::string("a bug of this program: ") + error.what(), ""};
  }
}

void ThrowIfFailed(const grpc::Status& status, const std::string& peer) {
  if (status.ok()) return;
  const std::string& text = status.error_message();
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::CANCELLED:
      throw UnreachableError(peer + " cannot be reached (" + text + "): does a lodestar-coordinator run there?");
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      throw UnreachableError(peer + " did not answer in time (" + text + ")");
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      throw ExhaustedError(text);
    case grpc::StatusCode::UNIMPLEMENTED:
      throw ProtocolError(peer + " does not know this call (" + text + "): install the same release on both ends");
    default:
      break;
  }
  if (status.error_details() == "protocol") throw ProtocolError(text);
  for (int kind = 0; kind < 6; ++kind) {
    if (status.error_details() == kKinds[kind]) throw Error(static_cast<ErrorKind>(kind), text);
  }
  throw Error(ErrorKind::kIo, peer + ": " + text);
}

}  // namespace lodestar
