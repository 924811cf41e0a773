#include "coordinator/handlers/work_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void ReportFailure(Farm& farm, const v1::ReportFailureRequest& request, v1::ReportFailureReply*) {
  farm.ReportFailure(FromProto(request));
}

}  // namespace lodestar
