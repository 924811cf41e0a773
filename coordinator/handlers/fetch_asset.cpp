#include <fstream>

#include "coordinator/handlers/work_handlers.h"

namespace lodestar {

std::function<bool(v1::AssetChunk*)> FetchAsset(Farm& farm, const v1::FetchAssetRequest& request) {
  auto in = std::make_shared<std::ifstream>(farm.blobs().PathOf({request.sha256()}), std::ios::binary);
  return [in, buffer = Bytes(kChunkBytes, '\0')](v1::AssetChunk* chunk) mutable {
    in->read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<size_t>(in->gcount());
    if (count == 0) return false;
    chunk->set_data(Compress({buffer.data(), count}));
    return true;
  };
}

}  // namespace lodestar
