#include "coordinator/handlers/farm_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void ListJobs(Farm& farm, const v1::ListJobsRequest&, v1::ListJobsReply* reply) {
  for (const auto& status : farm.List()) *reply->add_jobs() = ToProto(status);
}

}  // namespace lodestar
