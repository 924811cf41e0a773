#include "core/math/distribution.h"

#include <algorithm>

namespace lodestar {
AliasTable::AliasTable(std::span<const double> weights) : bins_(weights.size()), pmf_(weights.size()) {
  const size_t n = weights.size();
  LODESTAR_CHECK(n > 0 && n < (size_t{1} << 31));
  double total = 0;
  for (const double w : weights) {
    LODESTAR_CHECK(w >= 0 && std::isfinite(w));
    total += w;
  }
  LODESTAR_CHECK(total > 0);
  // Bins of less than average height take the rest of their height from one of more.
  std::vector<double> height(n);
  std::vector<uint32_t> small, large;
  for (size_t i = 0; i < n; ++i) {
    pmf_[i] = static_cast<float>(weights[i] / total);
    height[i] = weights[i] / total * double(n);
    (height[i] < 1 ? small : large).push_back(static_cast<uint32_t>(i));
  }
  while (!small.empty() && !large.empty()) {
    const uint32_t low = small.back(), high = large.back();
    small.pop_back();
    bins_[low] = {static_cast<float>(height[low]), high};
    height[high] -= 1 - height[low];
    if (height[high] < 1) {
      large.pop_back();
      small.push_back(high);
    }
  }
  // What is left has height one but for rounding. A weight of zero must not be picked even if rounding left it here.
  const auto heaviest = static_cast<uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  for (const uint32_t i : large) bins_[i] = {1, i};
  for (const uint32_t i : small) bins_[i] = weights[i] > 0 ? Bin{1, i} : Bin{0, heaviest};
}

}  // namespace lodestar
