#include "core/guiding/bsdf_fraction.h"

#include <algorithm>

#include "core/math/exact_sum_bytes.h"

namespace lodestar {

void FractionSums::Write(ByteWriter& out) const {
  PutVarint(out, count);
  if (count == 0) return;
  PutSum(out, weight);
  for (int i = 0; i < kFractionGrid; ++i) PutWide(out, GradientUnits(i));
}

FractionSums FractionSums::Read(ByteReader& in) {
  FractionSums sums;
  sums.count = GetVarint(in);
  if (sums.count > (uint64_t{1} << 40)) in.Fail("have an impossible record count");
  if (sums.count == 0) return sums;
  sums.weight = GetSum(in);
  for (int i = 0; i < kFractionGrid; ++i) {
    const __int128 units = GetWide(in), limit = static_cast<__int128>(sums.count) << 51;
    if (units > limit || units < -limit) in.Fail("have a gradient out of range");
    sums.SetGradientUnits(i, units);
  }
  return sums;
}

float SolveBsdfFraction(const FractionSums& sums, float previous, double prior_records) {
  if (sums.count == 0) return previous;
  const double mean_weight = sums.weight.Value() / static_cast<double>(sums.count);
  if (!(mean_weight > 0)) return previous;  // all weights are lost to rounding: the prior would be, too
  // h(alpha) = alpha (1 - alpha) dLoss/dalpha is linear in alpha where each direction is served by one technique only,
  // and nearly so elsewhere; linear interpolation of h is then exact or close with eight points. The prior, a cross
  // entropy towards `previous`, is linear in it as well.
  std::array<double, kFractionGrid> h;
  for (int i = 0; i < kFractionGrid; ++i) {
    const double alpha = kFractionAlphas[i];
    const double gradient = static_cast<double>(sums.GradientUnits(i)) * 0x1p-30;
    h[i] = alpha * (1 - alpha) * gradient + prior_records * mean_weight * (alpha - previous);
  }
  if (h[0] >= 0) return kMinBsdfFraction;
  for (int i = 1; i < kFractionGrid; ++i) {
    if (h[i] < 0) continue;
    const double t = h[i - 1] / (h[i - 1] - h[i]);
    const double alpha = kFractionAlphas[i - 1] + t * (kFractionAlphas[i] - kFractionAlphas[i - 1]);
    return std::clamp(static_cast<float>(alpha), kMinBsdfFraction, kMaxBsdfFraction);
  }
  return kMaxBsdfFraction;
}

}  // namespace lodestar
