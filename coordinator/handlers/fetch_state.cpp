#include "coordinator/handlers/work_handlers.h"

namespace lodestar {

std::function<bool(v1::StateChunk*)> FetchState(Farm& farm, const v1::FetchStateRequest& request) {
  return [bytes = farm.CompressedState({request.sha256()}), at = size_t{0}](v1::StateChunk* chunk) mutable {
    if (at == bytes->size()) return false;
    const size_t count = std::min(kChunkBytes, bytes->size() - at);
    chunk->set_data(bytes->data() + at, count);
    at += count;
    return true;
  };
}

}  // namespace lodestar
