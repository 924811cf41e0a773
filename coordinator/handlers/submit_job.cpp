#include "coordinator/handlers/farm_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void SubmitJob(Farm& farm, const v1::SubmitJobRequest& request, v1::SubmitJobReply* reply) {
  reply->set_job_id(farm.Submit(FromProto(request.job())).value);
}

}  // namespace lodestar
