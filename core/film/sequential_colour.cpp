#include <algorithm>

#include "core/film/oklab.h"
#include "core/math/elementary.h"

namespace lodestar {

std::array<uint8_t, 3> SequentialColour(float t) {
  constexpr float kFirstLightness = 0.24f, kLastLightness = 0.93f;
  constexpr float kFirstHue = 5.20f, kLastHue = 1.85f;  // radians: violet, yellow
  t = std::clamp(t, 0.0f, 1.0f);
  const auto [sin, cos] = SinCos(Lerp(t, kFirstHue, kLastHue));
  // Below what sRGB has room for all along the way: least at teal, and no colour is clipped.
  const float chroma = 0.093f + 0.2f * (t - 0.42f) * (t - 0.42f);
  return OklabToSrgb(Lerp(t, kFirstLightness, kLastLightness), chroma * cos, chroma * sin);
}

}  // namespace lodestar
