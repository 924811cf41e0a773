// The diverging map of FalseColour. Moreland 2009 ("Diverging color maps for scientific visualization") asks that such
// a map falls in lightness from a bright neutral middle alike to both sides. Ours is computed in Oklab (Ottosson 2020,
// "A perceptual color space for image processing"), where that is a straight line: lightness and chroma are linear in
// |t| along a fixed hue a side, blue below zero, orange above.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/film/error_metrics.h"
#include "core/math/elementary.h"

namespace lodestar {
namespace {

constexpr float kMiddleLightness = 0.97f, kEndLightness = 0.42f;
struct Hue {
  float a, b;  // Oklab chroma at the end of the scale
};
constexpr Hue kBelow{-0.03f, -0.150f}, kAbove{0.115f, 0.085f};

uint8_t SrgbByte(float linear) {
  linear = std::clamp(linear, 0.0f, 1.0f);
  const float encoded = linear <= 0.0031308f ? 12.92f * linear : 1.055f * Pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<uint8_t>(std::clamp(encoded * 255 + 0.5f, 0.0f, 255.0f));
}

std::array<uint8_t, 3> Colour(float t) {
  const float size = std::fabs(t);
  const Hue hue = t < 0 ? kBelow : kAbove;
  const float lightness = kMiddleLightness + (kEndLightness - kMiddleLightness) * size;
  // Chroma rises fast, so that small errors show a side at all.
  const float chroma = size * (2 - size);
  const float a = hue.a * chroma, b = hue.b * chroma;
  const auto cube = [](float v) { return v * v * v; };
  const float l = cube(lightness + 0.3963377774f * a + 0.2158037573f * b);
  const float m = cube(lightness - 0.1055613458f * a - 0.0638541728f * b);
  const float s = cube(lightness - 0.0894841775f * a - 1.2914855480f * b);
  return {SrgbByte(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s),
          SrgbByte(-1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s),
          SrgbByte(-0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s)};
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
