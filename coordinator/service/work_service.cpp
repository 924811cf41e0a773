#include "coordinator/handlers/work_handlers.h"
#include "coordinator/service/reactors.h"
#include "coordinator/service/services.h"

namespace lodestar {
namespace {

using Context = grpc::CallbackServerContext;

class WorkService final : public v1::Work::CallbackService {
 public:
  WorkService(Farm& farm, WorkPool& pool) : farm_(farm), pool_(pool) {}

  grpc::ServerUnaryReactor* Register(Context* c, const v1::RegisterRequest* q, v1::RegisterReply* r) override {
    return Call(c, q, r, lodestar::Register);
  }
  grpc::ServerUnaryReactor* SubmitSurvey(Context* c, const v1::SubmitSurveyRequest* q,
                                         v1::SubmitSurveyReply* r) override {
    return Call(c, q, r, lodestar::SubmitSurvey);
  }
  grpc::ServerUnaryReactor* ReportFailure(Context* c, const v1::ReportFailureRequest* q,
                                          v1::ReportFailureReply* r) override {
    return Call(c, q, r, lodestar::ReportFailure);
  }
  grpc::ServerUnaryReactor* Lease(Context* c, const v1::LeaseRequest* q, v1::LeaseReply* r) override {
    return Park(c, q, r, lodestar::Lease);
  }
  grpc::ServerUnaryReactor* RenewLease(Context* c, const v1::RenewLeaseRequest* q, v1::RenewLeaseReply* r) override {
    return Park(c, q, r, lodestar::RenewLease);
  }
  grpc::ServerWriteReactor<v1::StateChunk>* FetchState(Context* c, const v1::FetchStateRequest* q) override {
    return ChunkWriter<v1::StateChunk>::Start(c, pool_, q, [this, q] { return lodestar::FetchState(farm_, *q); });
  }
  grpc::ServerWriteReactor<v1::AssetChunk>* FetchAsset(Context* c, const v1::FetchAssetRequest* q) override {
    return ChunkWriter<v1::AssetChunk>::Start(c, pool_, q, [this, q] { return lodestar::FetchAsset(farm_, *q); });
  }
  grpc::ServerReadReactor<v1::ContributionChunk>* SubmitContribution(Context* c,
                                                                     v1::SubmitContributionReply* r) override {
    return new ChunkReader<lodestar::SubmitContribution, v1::ContributionChunk, v1::SubmitContributionReply>(c, pool_,
                                                                                                             r, farm_);
  }

 private:
  template <class Request, class Reply>
  grpc::ServerUnaryReactor* Call(Context* context, const Request* request, Reply* reply,
                                 void (*handler)(Farm&, const Request&, Reply*)) {
    return Answer<Request, Reply>(context, pool_, request, reply,
                                  [this, handler](const Request& q, Reply* r) { handler(farm_, q, r); });
  }
  template <class Request, class Reply>
  grpc::ServerUnaryReactor* Park(Context* context, const Request* request, Reply* reply,
                                 uint64_t (*handler)(Farm&, const Request&, std::function<bool(const Reply&)>)) {
    if (const auto status = CheckProtocol(context); !status.ok()) {
      auto* reactor = context->DefaultReactor();
      reactor->Finish(status);
      return reactor;
    }
    auto* call = new ParkedCall<Reply>(reply, [this](uint64_t number) { farm_.Withdraw(number); });
    call->Park([&](std::function<bool(const Reply&)> answer) {
      RefuseUnknownFields(*request);
      return handler(farm_, *request, std::move(answer));
    });
    return call;
  }
  Farm& farm_;
  WorkPool& pool_;
};

}  // namespace

std::unique_ptr<grpc::Service> NewWorkService(Farm& farm, WorkPool& pool) {
  return std::make_unique<WorkService>(farm, pool);
}

}  // namespace lodestar
