// Channels and contexts as both ends agree on them.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <memory>
#include <string>

#include "core/base/clock.h"

namespace lodestar {

inline constexpr const char* kProtocolKey = "lodestar-protocol";
inline constexpr int kKeepaliveMs = 20000, kKeepaliveTimeoutMs = 10000;

// Keepalive pings also while no call is under way, quick reconnection, and message limits. Not TLS yet: see
// docs/farm.md.
std::shared_ptr<grpc::Channel> OpenChannel(const std::string& address);
// The protocol's metadata and a deadline; 0: none.
void PrepareContext(grpc::ClientContext* context, Clock::Duration deadline);

}  // namespace lodestar
