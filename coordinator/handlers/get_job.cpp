#include "coordinator/handlers/farm_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void GetJob(Farm& farm, const v1::GetJobRequest& request, v1::GetJobReply* reply) {
  *reply->mutable_job() = ToProto(farm.Get({request.job_id()}));
}

}  // namespace lodestar
