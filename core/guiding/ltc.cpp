#include "core/guiding/ltc.h"

#include <iterator>

namespace lodestar {
namespace {

// Widths and skew over alpha; the peak's sine less that of the mirror direction. All are smooth, most are nearly
// constant.
constexpr LtcShape kTable[] = {
#include "core/guiding/ltc_table.inc"
};
static_assert(std::size(kTable) == LtcTable::kAlphas * LtcTable::kAngles);

LtcShape Blend(const LtcShape& a, const LtcShape& b, float t) {
  return {Lerp(t, a.x, b.x), Lerp(t, a.y, b.y), Lerp(t, a.skew, b.skew), Lerp(t, a.peak_sin, b.peak_sin)};
}

}  // namespace

LtcShape LtcTable::GgxReflection(float alpha, float cos_o) {
  alpha = std::clamp(alpha, kMinAlpha, 1.0f);
  cos_o = std::clamp(cos_o, kMinCos, 1.0f);
  const float root = std::sqrt(kMinAlpha);
  const float i = (std::sqrt(alpha) - root) * ((kAlphas - 1) / (1 - root));
  const float j = std::sqrt((1 - cos_o) * (1 / (1 - kMinCos))) * (kAngles - 1);
  const int row = std::min(static_cast<int>(i), kAlphas - 2), column = std::min(static_cast<int>(j), kAngles - 2);
  const LtcShape* const entry = kTable + row * kAngles + column;
  const float ti = i - static_cast<float>(row), tj = j - static_cast<float>(column);
  LtcShape shape = Blend(Blend(entry[0], entry[1], tj), Blend(entry[kAngles], entry[kAngles + 1], tj), ti);
  shape.x *= alpha;
  shape.y *= alpha;
  shape.skew *= alpha;
  shape.peak_sin = std::clamp(shape.peak_sin + SafeSqrt(1 - cos_o * cos_o), 0.0f, 0.9999f);
  return shape;
}

}  // namespace lodestar
