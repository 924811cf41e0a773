#include "core/guiding/light_selection.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace lodestar {

std::vector<uint16_t> QuantizeShares(std::span<const double> shares) {
  LODESTAR_CHECK(shares.size() >= 2 && shares.size() <= kMostLightGroups);
  double total = 0;
  for (const double share : shares) total += share;
  LODESTAR_CHECK(total > 0);
  // One unit each, the others by share; what rounding leaves goes to the largest.
  const double units = 65536.0 - static_cast<double>(shares.size());
  std::vector<uint16_t> out;
  uint32_t left = 65536;
  for (const double share : shares) {
    out.push_back(static_cast<uint16_t>(1 + std::floor(units * (share / total))));
    left -= out.back();
  }
  *std::max_element(out.begin(), out.end()) += static_cast<uint16_t>(left);
  return out;
}

std::vector<uint16_t> SolveLightSelection(std::span<const ExactSum> sums, std::span<const uint16_t> by_power,
                                          std::span<const uint16_t> previous) {
  std::vector<double> shares;
  double total = 0;
  for (const ExactSum& sum : sums) {
    shares.push_back(std::sqrt(sum.Value()));
    total += shares.back();
  }
  if (!(total > 0)) return {previous.begin(), previous.end()};
  for (size_t g = 0; g < shares.size(); ++g)
    shares[g] =
        (1 - kLightsByPower) * (shares[g] / total) + kLightsByPower * 0x1p-16 * static_cast<double>(by_power[g]);
  return QuantizeShares(shares);
}

}  // namespace lodestar
