#include "coordinator/handlers/farm_handlers.h"
#include "coordinator/handlers/in_chunks.h"

namespace lodestar {

std::function<bool(v1::GuideChunk*)> GetGuide(Farm& farm, const v1::GetGuideRequest& request) {
  return InChunks<v1::GuideChunk>(std::make_shared<const Bytes>(farm.GetGuide({request.job_id()})));
}

}  // namespace lodestar
