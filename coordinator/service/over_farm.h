// What both gRPC services are made of: handlers over a farm, run on a pool.
#pragma once

#include "coordinator/service/reactors.h"
#include "coordinator/service/services.h"

namespace lodestar {

class Farm;

template <class CallbackService>
class OverFarm : public CallbackService {
 public:
  using Context = grpc::CallbackServerContext;
  OverFarm(Farm& farm, WorkPool& pool) : farm_(farm), pool_(pool) {}

 protected:
  template <class Request, class Reply>
  grpc::ServerUnaryReactor* Call(Context* context, const Request* request, Reply* reply,
                                 void (*handler)(Farm&, const Request&, Reply*)) {
    return Answer<Request, Reply>(context, pool_, request, reply,
                                  [this, handler](const Request& q, Reply* r) { handler(farm_, q, r); });
  }
  // Answers in parts that `handler` makes.
  template <class Request, class Chunk>
  grpc::ServerWriteReactor<Chunk>* Parts(Context* context, const Request* request,
                                         std::function<bool(Chunk*)> (*handler)(Farm&, const Request&)) {
    return ChunkWriter<Chunk>::Start(context, pool_, request,
                                     [this, request, handler] { return handler(farm_, *request); });
  }
  Farm& farm_;
  WorkPool& pool_;
};

}  // namespace lodestar
