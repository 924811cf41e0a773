#include "coordinator/handlers/farm_handlers.h"

namespace lodestar {

void GetReport(Farm& farm, const v1::GetReportRequest& request, v1::GetReportReply* reply) {
  reply->set_json(farm.GetReport({request.job_id()}));
}

}  // namespace lodestar
