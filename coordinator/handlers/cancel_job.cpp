#include "coordinator/handlers/farm_handlers.h"

namespace lodestar {

void CancelJob(Farm& farm, const v1::CancelJobRequest& request, v1::CancelJobReply*) {
  farm.Cancel({request.job_id()});
}

}  // namespace lodestar
