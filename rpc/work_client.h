// A worker's calls to its coordinator: plain values in and out, one attempt each (the worker's loops decide about
// retries, for ever).
//
// Every method throws: UnreachableError (retry later), ProtocolError (never), Error(kNotFound) for a worker or content
// that is unknown, else what the coordinator said. Safe to use from several threads.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "rpc/status.h"
#include "rpc/work_types.h"

namespace lodestar {

class WorkClient {
 public:
  explicit WorkClient(const std::string& address);
  ~WorkClient();

  Registration Register(const WorkerInfo& info);
  std::optional<LeasedUnit> Lease(const WorkerId& worker, Clock::Duration wait);
  // The leases to give up.
  std::vector<LeaseId> RenewLease(const WorkerId& worker, const std::vector<LeaseId>& leases, Clock::Duration wait);
  Bytes FetchState(const ContentHash& hash);                     // verified
  Bytes FetchBytes(const ContentHash& hash, uint64_t max_size);  // a small asset, verified
  // Streams the content into a file that must not exist yet, verified; nothing is left behind on failure.
  void FetchAsset(const ContentHash& hash, const std::filesystem::path& file);
  // Fills in the header's size.
  ContributionOutcome SubmitContribution(ContributionHeader header, std::string_view bytes);
  void SubmitSurvey(const SurveyResult& result);
  void SubmitShard(const ShardAnswer& answer);
  void ReportFailure(const UnitFailure& failure);

  // Ends the calls under way with UnreachableError, and makes later ones fail at once.
  void Shutdown();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lodestar
