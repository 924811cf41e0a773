// What each RPC of the service Farm does (farm.proto has its contract). One file each; errors are thrown.
#pragma once

#include <functional>
#include <memory>

#include "coordinator/farm.h"
#include "lodestar/v1/farm.pb.h"

namespace lodestar {

void SubmitJob(Farm& farm, const v1::SubmitJobRequest& request, v1::SubmitJobReply* reply);
void GetJob(Farm& farm, const v1::GetJobRequest& request, v1::GetJobReply* reply);
void ListJobs(Farm& farm, const v1::ListJobsRequest& request, v1::ListJobsReply* reply);
void CancelJob(Farm& farm, const v1::CancelJobRequest& request, v1::CancelJobReply* reply);
void GetReport(Farm& farm, const v1::GetReportRequest& request, v1::GetReportReply* reply);
void ListWorkers(Farm& farm, const v1::ListWorkersRequest& request, v1::ListWorkersReply* reply);
void HasAssets(Farm& farm, const v1::HasAssetsRequest& request, v1::HasAssetsReply* reply);
// Answered in parts: fills in the next one; false after the last.
std::function<bool(v1::ImageChunk*)> GetImage(Farm& farm, const v1::GetImageRequest& request);
std::function<bool(v1::GuideChunk*)> GetGuide(Farm& farm, const v1::GetGuideRequest& request);
// Calls back with the status at each change; the number is for Farm::Unwatch.
uint64_t WatchJob(Farm& farm, const v1::WatchJobRequest& request, std::function<void(v1::JobStatus)> changed);

// Asked in parts.
class PutAsset {
 public:
  explicit PutAsset(Farm& farm) : farm_(farm) {}
  void Add(const v1::AssetChunk& chunk);
  void Finish(v1::PutAssetReply* reply);

 private:
  Farm& farm_;
  std::unique_ptr<BlobStore::Writer> writer_;
};

}  // namespace lodestar
