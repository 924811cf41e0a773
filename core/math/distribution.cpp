#include "core/math/distribution.h"

#include <algorithm>

#include "core/base/check.h"

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

double GuidedCdf::Build(std::span<const float> values, float* cdf, uint16_t* guide) {
  const auto cells = static_cast<uint32_t>(values.size());
  LODESTAR_CHECK(cells > 0 && cells <= 65536);
  double total = 0;
  for (const float v : values) {
    LODESTAR_CHECK(v >= 0 && std::isfinite(v));
    total += v;
  }
  double sum = 0;
  cdf[0] = 0;
  for (uint32_t i = 0; i < cells; ++i) {
    sum += values[i];
    cdf[i + 1] = static_cast<float>(total > 0 ? sum / total : double(i + 1) / double(cells));
  }
  // Everything behind the last positive value is 1 too, so that no u reaches a cell of zero density.
  for (uint32_t i = cells; i > 0 && (i == cells || (total > 0 && values[i] == 0)); --i) cdf[i] = 1;
  uint32_t cell = 0;
  for (uint32_t i = 0; i < cells; ++i) {
    // Just below the least u of this slot, however u * cells rounds.
    const float least = static_cast<float>(i) / static_cast<float>(cells) * (1 - 0x1p-22f);
    while (cell + 1 < cells && cdf[cell + 1] <= least) ++cell;
    guide[i] = static_cast<uint16_t>(cell);
  }
  return total;
}

PiecewiseConstant2D::PiecewiseConstant2D(std::span<const float> values, uint32_t width, uint32_t height)
    : width_(width),
      height_(height),
      marginal_cdf_(height + 1),
      cdf_(size_t{width + 1} * height),
      marginal_guide_(height),
      guide_(values.size()) {
  LODESTAR_CHECK(width > 0 && height > 0 && values.size() == size_t{width} * height);
  std::vector<float> rows(height);
  for (uint32_t y = 0; y < height; ++y) {
    const size_t first = size_t{y} * width;
    const double row = GuidedCdf::Build(values.subspan(first, width), &cdf_[first + y], &guide_[first]);
    rows[y] = static_cast<float>(row / width);
  }
  mean_ = GuidedCdf::Build(rows, marginal_cdf_.data(), marginal_guide_.data()) / height;
}

}  // namespace lodestar
