// The diverging map of FalseColour. Moreland 2009 ("Diverging color maps for scientific visualization") asks that such
// a map falls in lightness from a bright neutral middle alike to both sides. Ours is computed in Oklab (Ottosson 2020,
// "A perceptual color space for image processing"), where that is a straight line: lightness and chroma are linear in
// |t| along a fixed hue a side, blue below zero, orange above.
#include <algorithm>
#include <cmath>

#include "core/film/error_metrics.h"
#include "core/film/oklab.h"

namespace lodestar {
namespace {

constexpr float kMiddleLightness = 0.97f, kEndLightness = 0.42f;
struct Hue {
  float a, b;  // Oklab chroma at the end of the scale
};
constexpr Hue kBelow{-0.03f, -0.150f}, kAbove{0.115f, 0.085f};

std::array<uint8_t, 3> Colour(float t) {
  const float size = std::fabs(t);
  const Hue hue = t < 0 ? kBelow : kAbove;
  const float lightness = kMiddleLightness + (kEndLightness - kMiddleLightness) * size;
  // Chroma rises fast, so that small errors show a side at all.
  const float chroma = size * (2 - size);
  const float a = hue.a * chroma, b = hue.b * chroma;
  return OklabToSrgb(lightness, a, b);
}

}  // namespace

std::vector<uint8_t> FalseColour(const std::vector<float>& values, float limit) {
  std::vector<uint8_t> bytes;
  bytes.reserve(values.size() * 3);
  for (const float value : values) {
    // What is not a number must not pass for a small error: black, which the scale does not contain.
    const auto colour = std::isnan(value) ? std::array<uint8_t, 3>{} : Colour(std::clamp(value / limit, -1.0f, 1.0f));
    bytes.insert(bytes.end(), colour.begin(), colour.end());
  }
  return bytes;
}

}  // namespace lodestar
