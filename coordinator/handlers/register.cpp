#include "coordinator/handlers/work_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void Register(Farm& farm, const v1::RegisterRequest& request, v1::RegisterReply* reply) {
  const auto registration = farm.Register(FromProto(request));
  reply->set_worker_id(registration.id.value);
  reply->set_epoch(registration.epoch);
  reply->set_lease_ms(static_cast<uint32_t>(registration.lease_duration / std::chrono::milliseconds(1)));
}

}  // namespace lodestar
