#include "coordinator/handlers/farm_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void ListWorkers(Farm& farm, const v1::ListWorkersRequest&, v1::ListWorkersReply* reply) {
  for (const auto& status : farm.Workers()) *reply->add_workers() = ToProto(status);
}

}  // namespace lodestar
