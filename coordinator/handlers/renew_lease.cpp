#include "coordinator/handlers/work_handlers.h"

namespace lodestar {

uint64_t RenewLease(Farm& farm, const v1::RenewLeaseRequest& request,
                    std::function<bool(const v1::RenewLeaseReply&)> answer) {
  if (request.lease_ids_size() > 4096) throw Error(ErrorKind::kInvalidInput, "at most 4096 leases a call");
  std::vector<LeaseId> leases;
  for (const auto id : request.lease_ids()) leases.push_back({id});
  const auto wait = std::chrono::milliseconds(std::min(request.wait_ms(), 30000u));
  return farm.RenewLease({request.worker_id()}, leases, wait,
                         [answer = std::move(answer)](std::vector<LeaseId> revoked) {
                           v1::RenewLeaseReply reply;
                           for (const auto id : revoked) reply.add_revoked(id.value);
                           (void)answer(reply);
                         });
}

}  // namespace lodestar
