#include "coordinator/handlers/farm_handlers.h"
#include "coordinator/handlers/in_chunks.h"
#include "rpc/image_bytes.h"

namespace lodestar {

std::function<bool(v1::ImageChunk*)> GetImage(Farm& farm, const v1::GetImageRequest& request) {
  return InChunks<v1::ImageChunk>(std::make_shared<const Bytes>(ImageToBytes(*farm.GetImage({request.job_id()}))));
}

}  // namespace lodestar
