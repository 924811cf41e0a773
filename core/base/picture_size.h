// The pictures that can be rendered: both sides have 1 to kMaxSide pixels, and together at most kMaxPixels.
#pragma once

#include <cstdint>
#include <string>

namespace lodestar {

constexpr uint32_t kMaxSide = 1 << 16;
constexpr uint64_t kMaxPixels = uint64_t{1} << 28;

constexpr bool CanBeRendered(int64_t width, int64_t height) {
  return width > 0 && height > 0 && width <= kMaxSide && height <= kMaxSide &&
         static_cast<uint64_t>(width * height) <= kMaxPixels;
}

// "each side may have 1 to ...", for messages.
inline std::string PictureSizeRule() {
  return "each side may have 1 to " + std::to_string(kMaxSide) + ", both together " + std::to_string(kMaxPixels) +
         " pixels";
}

}  // namespace lodestar
