#include <cstring>

#include "coordinator/handlers/farm_handlers.h"

namespace lodestar {

std::function<bool(v1::ImageChunk*)> GetImage(Farm& farm, const v1::GetImageRequest& request) {
  return [image = farm.GetImage({request.job_id()}), at = size_t{0}](v1::ImageChunk* chunk) mutable {
    if (at > 0 && at == image->size()) return false;
    if (at == 0) {
      chunk->set_width(image->width);
      chunk->set_height(image->height);
    }
    const size_t count = std::min(image->size() - at, kChunkBytes / 16);
    std::string data(count * 16, '\0');
    for (size_t i = 0; i < count; ++i) {
      const Rgb& p = image->pixels[at + i];
      const float values[4] = {p.r, p.g, p.b, image->variance[at + i]};
      std::memcpy(data.data() + i * 16, values, 16);
    }
    chunk->set_data(std::move(data));
    at += count;
    return true;
  };
}

}  // namespace lodestar
