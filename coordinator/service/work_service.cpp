#include "coordinator/handlers/work_handlers.h"
#include "coordinator/service/over_farm.h"

namespace lodestar {
namespace {

class WorkService final : public OverFarm<v1::Work::CallbackService> {
 public:
  using OverFarm::OverFarm;

  grpc::ServerUnaryReactor* Register(Context* c, const v1::RegisterRequest* q, v1::RegisterReply* r) override {
    return Call(c, q, r, lodestar::Register);
  }
  grpc::ServerUnaryReactor* SubmitSurvey(Context* c, const v1::SubmitSurveyRequest* q,
                                         v1::SubmitSurveyReply* r) override {
    return Call(c, q, r, lodestar::SubmitSurvey);
  }
  grpc::ServerUnaryReactor* SubmitShard(Context* c, const v1::SubmitShardRequest* q, v1::SubmitShardReply* r) override {
    return Call(c, q, r, lodestar::SubmitShard);
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
    return Parts(c, q, lodestar::FetchState);
  }
  grpc::ServerWriteReactor<v1::AssetChunk>* FetchAsset(Context* c, const v1::FetchAssetRequest* q) override {
    return Parts(c, q, lodestar::FetchAsset);
  }
  grpc::ServerReadReactor<v1::ContributionChunk>* SubmitContribution(Context* c,
                                                                     v1::SubmitContributionReply* r) override {
    return new ChunkReader<lodestar::SubmitContribution, v1::ContributionChunk, v1::SubmitContributionReply>(c, pool_,
                                                                                                             r, farm_);
  }

 private:
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
};

}  // namespace

std::unique_ptr<grpc::Service> NewWorkService(Farm& farm, WorkPool& pool) {
  return std::make_unique<WorkService>(farm, pool);
}

}  // namespace lodestar
