#include "coordinator/service/server.h"

#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include "coordinator/service/services.h"
#include "core/base/threads.h"
#include "rpc/channel.h"

namespace lodestar {
namespace {

bool IsLoopback(const std::string& host) {
  if (host == "localhost" || host == "[::1]") return true;
  // A dotted quad of 127/8; a name that merely begins so is not one.
  return host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos;
}

std::string HostOf(const std::string& listen) {
  const auto colon = listen.rfind(':');
  if (colon == std::string::npos) throw Error(ErrorKind::kInvalidInput, "'" + listen + "' is not HOST:PORT");
  return listen.substr(0, colon);
}

}  // namespace

struct Server::Impl {
  explicit Impl(Farm& farm) : farm_service(NewFarmService(farm, pool)), work_service(NewWorkService(farm, pool)) {}
  // More than the machine has: some of them wait for the disk, or (a client's image) for a round's edge, which others
  // must bring about.
  WorkPool pool{UsableThreads() + 4};
  std::unique_ptr<grpc::Service> farm_service, work_service;
  std::unique_ptr<grpc::Server> server;
  int port = 0;
  std::string address;
};

void Server::CheckAddress(const Options& options) {
  const std::string host = HostOf(options.listen);
  if (!IsLoopback(host) && !options.insecure) {
    throw Error(ErrorKind::kInvalidInput,
                "listening on '" + host +
                    "' would let anyone who reaches this machine submit jobs and results, without encryption; " +
                    "listen on 127.0.0.1, or say --insecure on a network that you trust");
  }
}

Server::Server(Farm& farm, const Options& options) : impl_(std::make_unique<Impl>(farm)) {
  CheckAddress(options);
  grpc::ServerBuilder builder;
  builder.AddListeningPort(options.listen, grpc::InsecureServerCredentials(), &impl_->port);
  builder.RegisterService(impl_->farm_service.get());
  builder.RegisterService(impl_->work_service.get());
  builder.SetMaxReceiveMessageSize(static_cast<int>(kMaxMessageBytes));
  builder.SetMaxSendMessageSize(static_cast<int>(kMaxMessageBytes));
  builder.SetResourceQuota(grpc::ResourceQuota("coordinator").Resize(size_t{1} << 30));
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kKeepaliveMs / 2);
  impl_->server = builder.BuildAndStart();
  if (!impl_->server || impl_->port == 0)
    throw Error(ErrorKind::kIo,
                options.listen + " cannot be listened on: is the port taken, or the address not this machine's?");
  impl_->address = HostOf(options.listen) + ":" + std::to_string(impl_->port);
}

Server::~Server() {
  if (impl_->server) impl_->server->Shutdown(std::chrono::system_clock::now() + std::chrono::milliseconds(500));
  // What calls have left in the pool still speaks to the services.
  impl_->pool.Drain();
}

int Server::port() const {
  return impl_->port;
}
const std::string& Server::address() const {
  return impl_->address;
}

}  // namespace lodestar
