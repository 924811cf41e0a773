#include "core/film/oklab.h"

namespace lodestar {

std::array<uint8_t, 3> SequentialColour(float t) {
  constexpr float kFirstLightness = 0.24f, kLastLightness = 0.93f;
  constexpr float kFirstHue = 5.20f, kLastHue = 1.85f;  // radians: violet, yellow
  t = std::clamp(t, 0.0f, 1.0f);
  const auto [sin, cos] = SinCos(Lerp(t, kFirstHue, kLastHue));
  const float chroma = 0.105f + 0.02f * t + 0.10f * (t - 0.5f) * (t - 0.5f);
  return OklabToSrgb(Lerp(t, kFirstLightness, kLastLightness), chroma * cos, chroma * sin);
}

}  // namespace lodestar
