#include "coordinator/handlers/work_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void SubmitSurvey(Farm& farm, const v1::SubmitSurveyRequest& request, v1::SubmitSurveyReply*) {
  farm.SubmitSurvey(FromProto(request));
}

}  // namespace lodestar
