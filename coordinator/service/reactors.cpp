#include "coordinator/service/reactors.h"

#include "rpc/channel.h"

namespace lodestar {

grpc::Status CheckProtocol(const grpc::CallbackServerContext* context) {
  const auto& metadata = context->client_metadata();
  const auto found = metadata.find(kProtocolKey);
  const std::string mine = std::to_string(kProtocolVersion);
  if (found == metadata.end()) {
    return {grpc::StatusCode::FAILED_PRECONDITION,
            std::string("a call without the metadata '") + kProtocolKey + "': this coordinator speaks protocol " + mine,
            "protocol"};
  }
  const std::string theirs(found->second.data(), found->second.size());
  if (theirs == mine) return grpc::Status::OK;
  return {grpc::StatusCode::FAILED_PRECONDITION,
          "the caller speaks protocol " + theirs.substr(0, 20) + ", this coordinator " + mine +
              ": install the same release on both",
          "protocol"};
}

grpc::Status QueueFull() {
  return {grpc::StatusCode::RESOURCE_EXHAUSTED, "the coordinator has too many calls waiting: try again later", "io"};
}

}  // namespace lodestar
