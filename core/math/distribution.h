// Discrete and piecewise-constant distributions, built once in double precision and sampled by one or two uniform
// numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace lodestar {

// Walker's alias method (Vose 1991): constant-time choice among n weights. Weights must be finite and >= 0 with a
// positive sum (checked).
class AliasTable {
 public:
  AliasTable() = default;
  explicit AliasTable(std::span<const double> weights);

  // The index picked by u in [0, 1).
  uint32_t Sample(float u) const {
    const float scaled = u * static_cast<float>(bins_.size());
    const uint32_t bin = std::min(static_cast<uint32_t>(scaled), static_cast<uint32_t>(bins_.size() - 1));
    return scaled - static_cast<float>(bin) < bins_[bin].keep ? bin : bins_[bin].alias;
  }
  // Probability of an index.
  float Pmf(uint32_t index) const { return pmf_[index]; }
  size_t size() const { return bins_.size(); }

 private:
  struct Bin {
    float keep;
    uint32_t alias;
  };
  std::vector<Bin> bins_;
  std::vector<float> pmf_;
};

// The inverse of a piecewise linear distribution function over `cells` even cells of [0, 1): finds the cell of u in
// about two steps, from a table of where to start (the "guide table" of Chen and Asau 1974; Devroye 1986, section
// III.2.4).
class GuidedCdf {
 public:
  // Of values >= 0, one a cell; uniform where all are zero. `cdf` receives cells + 1 numbers, `guide` cells: both are
  // the caller's to keep. At most 65536 cells. Returns the values' sum.
  static double Build(std::span<const float> values, float* cdf, uint16_t* guide);
  // The cell whose half-open interval holds u; never one of zero width.
  static uint32_t Find(const float* cdf, const uint16_t* guide, uint32_t cells, float u) {
    uint32_t cell = guide[std::min(static_cast<uint32_t>(u * static_cast<float>(cells)), cells - 1)];
    while (cell + 1 < cells && cdf[cell + 1] <= u) ++cell;
    return cell;
  }
  // Where in [0, 1) u lies, linear within its cell.
  static float Position(const float* cdf, uint32_t cell, uint32_t cells, float u) {
    const float width = cdf[cell + 1] - cdf[cell];
    const float inside = width > 0 ? std::clamp((u - cdf[cell]) / width, 0.0f, kOneMinusEpsilon) : 0.5f;
    const float x = (static_cast<float>(cell) + inside) / static_cast<float>(cells);
    // Rounding up would move the sample to the neighbour's density.
    const float end = static_cast<float>(cell + 1) / static_cast<float>(cells);
    return x < end ? x : std::nextafter(end, 0.0f);
  }
};

// A density on the unit square that is constant in each of width * height cells, uniform where all values are zero:
// values row by row (x fastest), y first by the marginal, then x within the row. It keeps no densities: who samples
// it has the values at hand, and Density() scales them.
class PiecewiseConstant2D {
 public:
  struct Sampled {
    Vec2 p;
    uint32_t cell_x, cell_y;
  };
  PiecewiseConstant2D() = default;
  // At most 65536 cells either way.
  PiecewiseConstant2D(std::span<const float> values, uint32_t width, uint32_t height);

  Sampled Sample(Vec2 u) const {
    const uint32_t y = GuidedCdf::Find(marginal_cdf_.data(), marginal_guide_.data(), height_, u.y);
    const float* cdf = cdf_.data() + size_t{y} * (width_ + 1);
    const uint32_t x = GuidedCdf::Find(cdf, guide_.data() + size_t{y} * width_, width_, u.x);
    return {
        {GuidedCdf::Position(cdf, x, width_, u.x), GuidedCdf::Position(marginal_cdf_.data(), y, height_, u.y)}, x, y};
  }
  // Of a cell of that value.
  float Density(float value) const { return mean_ > 0 ? static_cast<float>(value / mean_) : 1.0f; }
  // Mean of the values.
  double mean() const { return mean_; }
  size_t memory_bytes() const {
    return (cdf_.size() + marginal_cdf_.size()) * sizeof(float) +
           (guide_.size() + marginal_guide_.size()) * sizeof(uint16_t);
  }

 private:
  uint32_t width_ = 0, height_ = 0;
  double mean_ = 0;
  std::vector<float> marginal_cdf_, cdf_;         // height + 1; width + 1 a row
  std::vector<uint16_t> marginal_guide_, guide_;  // height; width a row
};

}  // namespace lodestar
