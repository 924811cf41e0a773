#include "coordinator/handlers/farm_handlers.h"
#include "coordinator/service/over_farm.h"

namespace lodestar {
namespace {

class FarmService final : public OverFarm<v1::Farm::CallbackService> {
 public:
  using OverFarm::OverFarm;

  grpc::ServerUnaryReactor* SubmitJob(Context* c, const v1::SubmitJobRequest* q, v1::SubmitJobReply* r) override {
    return Call(c, q, r, lodestar::SubmitJob);
  }
  grpc::ServerUnaryReactor* GetJob(Context* c, const v1::GetJobRequest* q, v1::GetJobReply* r) override {
    return Call(c, q, r, lodestar::GetJob);
  }
  grpc::ServerUnaryReactor* ListJobs(Context* c, const v1::ListJobsRequest* q, v1::ListJobsReply* r) override {
    return Call(c, q, r, lodestar::ListJobs);
  }
  grpc::ServerUnaryReactor* CancelJob(Context* c, const v1::CancelJobRequest* q, v1::CancelJobReply* r) override {
    return Call(c, q, r, lodestar::CancelJob);
  }
  grpc::ServerUnaryReactor* GetReport(Context* c, const v1::GetReportRequest* q, v1::GetReportReply* r) override {
    return Call(c, q, r, lodestar::GetReport);
  }
  grpc::ServerUnaryReactor* ListWorkers(Context* c, const v1::ListWorkersRequest* q, v1::ListWorkersReply* r) override {
    return Call(c, q, r, lodestar::ListWorkers);
  }
  grpc::ServerUnaryReactor* HasAssets(Context* c, const v1::HasAssetsRequest* q, v1::HasAssetsReply* r) override {
    return Call(c, q, r, lodestar::HasAssets);
  }
  grpc::ServerWriteReactor<v1::ImageChunk>* GetImage(Context* c, const v1::GetImageRequest* q) override {
    return Parts(c, q, lodestar::GetImage);
  }
  grpc::ServerWriteReactor<v1::GuideChunk>* GetGuide(Context* c, const v1::GetGuideRequest* q) override {
    return Parts(c, q, lodestar::GetGuide);
  }
  grpc::ServerReadReactor<v1::AssetChunk>* PutAsset(Context* c, v1::PutAssetReply* r) override {
    return new ChunkReader<lodestar::PutAsset, v1::AssetChunk, v1::PutAssetReply>(c, pool_, r, farm_);
  }
  grpc::ServerWriteReactor<v1::JobStatus>* WatchJob(Context* c, const v1::WatchJobRequest* q) override {
    auto* writer = new NewestWriter<v1::JobStatus>(
        [](const v1::JobStatus& status) { return Ended(static_cast<JobPhase>(status.phase())); });
    if (const auto status = CheckProtocol(c); !status.ok()) {
      writer->Refuse(status);
    } else {
      writer->Start(
          [&](std::function<void(v1::JobStatus)> changed) {
            RefuseUnknownFields(*q);
            return lodestar::WatchJob(farm_, *q, std::move(changed));
          },
          [this](uint64_t number) { farm_.Unwatch(number); });
    }
    return writer;
  }
};

}  // namespace

std::unique_ptr<grpc::Service> NewFarmService(Farm& farm, WorkPool& pool) {
  return std::make_unique<FarmService>(farm, pool);
}

}  // namespace lodestar
