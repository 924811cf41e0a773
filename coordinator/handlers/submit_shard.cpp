#include "coordinator/handlers/work_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void SubmitShard(Farm& farm, const v1::SubmitShardRequest& request, v1::SubmitShardReply*) {
  farm.SubmitShard(FromProto(request));
}

}  // namespace lodestar
