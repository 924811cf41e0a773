// An image as the store keeps it, as a client uploads a reference and as it is sent to one: width, height, then (r, g,
// b, variance) floats, rows from the top.
#pragma once

#include "core/film/film.h"

namespace lodestar {

Bytes ImageToBytes(const Image& image);
// Of such an image; `width` and `height` are those of a job, which are bounded.
uint64_t ImageBytesSize(uint32_t width, uint32_t height);
Image ImageFromBytes(std::string_view bytes);  // throws Error(kCorrupt)

}  // namespace lodestar
