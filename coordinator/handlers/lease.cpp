#include "coordinator/handlers/work_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

uint64_t Lease(Farm& farm, const v1::LeaseRequest& request, std::function<bool(const v1::LeaseReply&)> answer) {
  const WorkerId worker{request.worker_id()};
  const auto wait = std::chrono::milliseconds(std::min(request.wait_ms(), 30000u));
  return farm.Lease(worker, wait, [&farm, worker, answer = std::move(answer)](std::optional<LeasedUnit> unit) {
    v1::LeaseReply reply;
    if (unit) *reply.mutable_lease() = ToProto(*unit);
    if (answer(reply) || !unit) return;
    // The worker has hung up: its lease need not wait for its expiry.
    try {
      farm.ReportFailure({UnitFailure::Kind::kReturned, worker, unit->id, unit->job, ""});
    } catch (const Error&) {
    }
  });
}

}  // namespace lodestar
