#include "core/math/distribution.h"

#include <algorithm>

#include "core/base/check.h"

namespace lodestar {
namespace {

// Cumulative sums of values / total, ending in exactly 1; returns the total.
double BuildCdf(std::span<const float> values, float* cdf) {
  double total = 0;
  for (const float v : values) {
    LODESTAR_CHECK(v >= 0 && std::isfinite(v));
    total += v;
  }
  double sum = 0;
  cdf[0] = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    cdf[i + 1] = static_cast<float>(total > 0 ? sum / total : double(i + 1) / double(values.size()));
  }
  // Everything behind the last positive value is 1 too, so that no u reaches a cell of zero density.
  for (size_t i = values.size(); i > 0 && (i == values.size() || (total > 0 && values[i] == 0)); --i) cdf[i] = 1;
  return total;
}

// The cell whose half-open interval of the cdf holds u; never one of zero width.
uint32_t FindCell(const float* cdf, uint32_t cells, float u) {
  const float* above = std::upper_bound(cdf, cdf + cells + 1, u);
  const auto cell = static_cast<uint32_t>(std::max<std::ptrdiff_t>(above - cdf - 1, 0));
  return std::min(cell, cells - 1);
}

float PositionInCell(const float* cdf, uint32_t cell, uint32_t cells, float u) {
  const float width = cdf[cell + 1] - cdf[cell];
  const float inside = width > 0 ? std::clamp((u - cdf[cell]) / width, 0.0f, kOneMinusEpsilon) : 0.5f;
  const float x = (static_cast<float>(cell) + inside) / static_cast<float>(cells);
  // Rounding up would move the sample to the neighbour's density.
  const float end = static_cast<float>(cell + 1) / static_cast<float>(cells);
  return x < end ? x : std::nextafter(end, 0.0f);
}

}  // namespace

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

PiecewiseConstant1D::PiecewiseConstant1D(std::span<const float> values) : cdf_(values.size() + 1), pdf_(values.size()) {
  LODESTAR_CHECK(!values.empty());
  const double total = BuildCdf(values, cdf_.data());
  integral_ = total / double(values.size());
  for (size_t i = 0; i < values.size(); ++i) pdf_[i] = static_cast<float>(total > 0 ? values[i] / integral_ : 1.0);
}

PiecewiseConstant1D::Sampled PiecewiseConstant1D::Sample(float u) const {
  const auto cells = static_cast<uint32_t>(pdf_.size());
  const uint32_t cell = FindCell(cdf_.data(), cells, u);
  return {PositionInCell(cdf_.data(), cell, cells, u), pdf_[cell], cell};
}

PiecewiseConstant2D::PiecewiseConstant2D(std::span<const float> values, uint32_t width, uint32_t height)
    : width_(width), height_(height), cdf_(size_t{width + 1} * height), pdf_(values.size()) {
  LODESTAR_CHECK(width > 0 && height > 0 && values.size() == size_t{width} * height);
  std::vector<float> rows(height);
  double total = 0;
  for (uint32_t y = 0; y < height; ++y) {
    const double row = BuildCdf(values.subspan(size_t{y} * width, width), cdf_.data() + size_t{y} * (width + 1));
    rows[y] = static_cast<float>(row / width);
    total += row;
  }
  marginal_ = PiecewiseConstant1D(rows);
  const double mean = total / double(values.size());
  for (size_t i = 0; i < values.size(); ++i) pdf_[i] = static_cast<float>(mean > 0 ? values[i] / mean : 1.0);
}

PiecewiseConstant2D::Sampled PiecewiseConstant2D::Sample(Vec2 u) const {
  const auto y = marginal_.Sample(u.y);
  const float* row = cdf_.data() + size_t{y.cell} * (width_ + 1);
  const uint32_t x = FindCell(row, width_, u.x);
  return {{PositionInCell(row, x, width_, u.x), y.x}, PdfOfCell(x, y.cell), x, y.cell};
}

float PiecewiseConstant2D::Pdf(Vec2 p) const {
  const auto w = static_cast<float>(width_), h = static_cast<float>(height_);
  return PdfOfCell(static_cast<uint32_t>(std::clamp(p.x * w, 0.0f, w - 1)),
                   static_cast<uint32_t>(std::clamp(p.y * h, 0.0f, h - 1)));
}

}  // namespace lodestar
