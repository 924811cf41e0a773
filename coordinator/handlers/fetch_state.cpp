#include "coordinator/handlers/in_chunks.h"
#include "coordinator/handlers/work_handlers.h"

namespace lodestar {

std::function<bool(v1::StateChunk*)> FetchState(Farm& farm, const v1::FetchStateRequest& request) {
  return InChunks<v1::StateChunk>(farm.StateBytes({request.sha256()}));
}

}  // namespace lodestar
