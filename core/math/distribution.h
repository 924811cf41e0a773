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

// A density on [0, 1) that is constant in each of n cells; uniform where all values are zero.
class PiecewiseConstant1D {
 public:
  struct Sampled {
    float x;
    float pdf;
    uint32_t cell;
  };
  PiecewiseConstant1D() = default;
  explicit PiecewiseConstant1D(std::span<const float> values);

  Sampled Sample(float u) const;
  float Pdf(float x) const { return pdf_[Cell(x)]; }
  // Mean of the values.
  double integral() const { return integral_; }

 private:
  uint32_t Cell(float x) const {
    const auto n = static_cast<float>(pdf_.size());
    return static_cast<uint32_t>(std::clamp(x * n, 0.0f, n - 1));
  }
  std::vector<float> cdf_;  // one more than cells
  std::vector<float> pdf_;
  double integral_ = 0;
};

// The same on the unit square: values row by row (x fastest), y first by the marginal, then x within the row.
class PiecewiseConstant2D {
 public:
  struct Sampled {
    Vec2 p;
    float pdf;
    uint32_t cell_x, cell_y;
  };
  PiecewiseConstant2D() = default;
  PiecewiseConstant2D(std::span<const float> values, uint32_t width, uint32_t height);

  Sampled Sample(Vec2 u) const;
  float Pdf(Vec2 p) const;
  float PdfOfCell(uint32_t x, uint32_t y) const { return pdf_[size_t{y} * width_ + x]; }
  double integral() const { return marginal_.integral(); }
  size_t memory_bytes() const { return (cdf_.size() + pdf_.size()) * sizeof(float); }

 private:
  uint32_t width_ = 0, height_ = 0;
  PiecewiseConstant1D marginal_;
  std::vector<float> cdf_;  // (width + 1) a row
  std::vector<float> pdf_;  // joint
};

}  // namespace lodestar
