// The transfer function of sRGB (IEC 61966-2-1), both ways; linear values and encoded ones in [0, 1].
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/math/elementary.h"

namespace lodestar {

inline float SrgbToLinear(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : Pow((encoded + 0.055f) / 1.055f, 2.4f);
}
inline float LinearToSrgb(float linear) {
  return linear <= 0.0031308f ? linear * 12.92f : 1.055f * Pow(linear, 1 / 2.4f) - 0.055f;
}

// The nearest byte. Values above 1 clip, those below 0 and NaN, which compares false, turn black.
inline uint8_t LinearToSrgb8(float linear) {
  if (!(linear > 0)) return 0;
  return static_cast<uint8_t>(std::min(LinearToSrgb(std::min(linear, 1.0f)), 1.0f) * 255 + 0.5f);
}

}  // namespace lodestar
