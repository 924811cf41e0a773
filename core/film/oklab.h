// Colours for maps of values: chosen in Oklab (Ottosson 2020, "A perceptual color space for image processing"), where
// equal steps look equal.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/srgb.h"

namespace lodestar {

// sRGB bytes of an Oklab colour; what sRGB does not have is clipped.
inline std::array<uint8_t, 3> OklabToSrgb(float lightness, float a, float b) {
  const auto cube = [](float v) { return v * v * v; };
  const float l = cube(lightness + 0.3963377774f * a + 0.2158037573f * b);
  const float m = cube(lightness - 0.1055613458f * a - 0.0638541728f * b);
  const float s = cube(lightness - 0.0894841775f * a - 1.2914855480f * b);
  return {LinearToSrgb8(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s),
          LinearToSrgb8(-1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s),
          LinearToSrgb8(-0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s)};
}

// A sequential map over [0, 1], clamped: lightness rises evenly from a dark violet over green to a light yellow, the
// hue turns evenly with it, and the chroma is what sRGB has room for.
std::array<uint8_t, 3> SequentialColour(float t);

}  // namespace lodestar
