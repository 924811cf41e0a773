#include "core/guiding/radiance_scale.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace lodestar {

float RadianceScaleFor(double mean) {
  return std::ldexp(1.0f, std::clamp(-std::ilogb(mean), -100, 100));
}

float ReadRadianceScale(ByteReader& in) {
  const auto scale = in.Get<float>();
  const uint32_t bits = std::bit_cast<uint32_t>(scale);
  if ((bits & 0x807fffff) != 0 || bits == 0 || !std::isfinite(scale)) in.Fail("has an invalid radiance scale");
  return scale;
}

}  // namespace lodestar
