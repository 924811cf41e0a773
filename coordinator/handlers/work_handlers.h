// What each RPC of the service Work does (worker.proto has its contract). One file each; errors are thrown.
#pragma once

#include <functional>
#include <optional>

#include "coordinator/farm.h"
#include "lodestar/v1/worker.pb.h"

namespace lodestar {

void Register(Farm& farm, const v1::RegisterRequest& request, v1::RegisterReply* reply);
void SubmitSurvey(Farm& farm, const v1::SubmitSurveyRequest& request, v1::SubmitSurveyReply* reply);
void SubmitShard(Farm& farm, const v1::SubmitShardRequest& request, v1::SubmitShardReply* reply);
void ReportFailure(Farm& farm, const v1::ReportFailureRequest& request, v1::ReportFailureReply* reply);

// Parked: `answer` is called once, now or later, from any thread; it returns false where nobody listens any more. The
// number is for Farm::Withdraw.
uint64_t Lease(Farm& farm, const v1::LeaseRequest& request, std::function<bool(const v1::LeaseReply&)> answer);
uint64_t RenewLease(Farm& farm, const v1::RenewLeaseRequest& request,
                    std::function<bool(const v1::RenewLeaseReply&)> answer);

// Answered in parts: fills in the next one; false after the last.
std::function<bool(v1::StateChunk*)> FetchState(Farm& farm, const v1::FetchStateRequest& request);
std::function<bool(v1::AssetChunk*)> FetchAsset(Farm& farm, const v1::FetchAssetRequest& request);

// Asked in parts.
class SubmitContribution {
 public:
  explicit SubmitContribution(Farm& farm) : farm_(farm) {}
  void Add(const v1::ContributionChunk& chunk);
  void Finish(v1::SubmitContributionReply* reply);

 private:
  Farm& farm_;
  std::optional<ContributionHeader> header_;
  Bytes bytes_;
};

}  // namespace lodestar
