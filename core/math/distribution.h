// Discrete and piecewise-constant distributions, built once in double precision and sampled by one or two uniform
// numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/math/vec.h"

namespace lodestar {

// Walker's alias method (Vose 1991): constant-time choice among n weights. Weights must be finite and >= 0 with a
// positive sum (checked).
class AliasTable {
 public:
  AliasTable() = default;
  explicit AliasTable(std::span<const double> weights);

  // The index picked by u in [0, 1). Of n weights each bin takes 1 / n of its steps, and the choice within the bin what
  // is left of them: a u of 24 bits is too coarse from some thousands on (Sampler::Refine).
  uint32_t Sample(double u) const {
    const double scaled = u * static_cast<double>(bins_.size());
    const uint32_t bin = std::min(static_cast<uint32_t>(scaled), static_cast<uint32_t>(bins_.size() - 1));
    return scaled - bin < bins_[bin].keep ? bin : bins_[bin].alias;
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

// The inverse of a piecewise linear distribution function over even cells of [0, 1): finds the cell of u from a table
// of where to start, four cells a slot (the guide table of Chen and Asau 1974; Devroye 1986, section III.2.4). The
// arrays are the caller's, so that what belongs to a cell can lie beside its end: ends[i * kStride] is the value at the
// end of cell i.
template <size_t kStride = 1>
class GuidedCdf {
 public:
  static constexpr uint32_t kMostCells = 65536;
  static uint32_t Slots(uint32_t cells) { return (cells + 3) / 4; }

  // Of values >= 0, one a cell; uniform where all are zero. Fills one end a cell and the guide's slots; returns the
  // values' sum.
  static double Build(std::span<const float> values, float* ends, uint16_t* guide);
  // The cell whose half-open interval holds u; never one of zero width.
  static uint32_t Find(const float* ends, const uint16_t* guide, uint32_t cells, float u) {
    const uint32_t slots = Slots(cells);
    uint32_t cell = guide[std::min(static_cast<uint32_t>(u * static_cast<float>(slots)), slots - 1)];
    while (cell + 1 < cells && ends[cell * kStride] <= u) ++cell;
    return cell;
  }
  // Where in [0, 1) u lies, linear within its cell.
  static float Position(const float* ends, uint32_t cell, uint32_t cells, float u) {
    const float start = cell > 0 ? ends[(cell - 1) * kStride] : 0, width = ends[cell * kStride] - start;
    const float inside = width > 0 ? std::clamp((u - start) / width, 0.0f, kOneMinusEpsilon) : 0.5f;
    const float x = (static_cast<float>(cell) + inside) / static_cast<float>(cells);
    // Rounding up would move the sample to the neighbour's density.
    const float end = static_cast<float>(cell + 1) / static_cast<float>(cells);
    return x < end ? x : std::nextafter(end, 0.0f);
  }
};

template <size_t kStride>
double GuidedCdf<kStride>::Build(std::span<const float> values, float* ends, uint16_t* guide) {
  const auto cells = static_cast<uint32_t>(values.size());
  LODESTAR_CHECK(cells > 0 && cells <= kMostCells);
  double total = 0;
  for (const float v : values) {
    LODESTAR_CHECK(v >= 0 && std::isfinite(v));
    total += v;
  }
  double sum = 0;
  for (uint32_t i = 0; i < cells; ++i) {
    sum += values[i];
    ends[i * kStride] = static_cast<float>(total > 0 ? sum / total : double(i + 1) / double(cells));
  }
  // Everything from the last positive value on is 1, so that no u reaches a cell of zero density.
  for (uint32_t i = cells; i > 0; --i) {
    ends[(i - 1) * kStride] = 1;
    if (total == 0 || values[i - 1] > 0) break;
  }
  const uint32_t slots = Slots(cells);
  for (uint32_t slot = 0, cell = 0; slot < slots; ++slot) {
    // Just below the slot's least u, however u * slots rounds.
    const float least = static_cast<float>(slot) / static_cast<float>(slots) * (1 - 0x1p-22f);
    while (cell + 1 < cells && ends[cell * kStride] <= least) ++cell;
    guide[slot] = static_cast<uint16_t>(cell);
  }
  return total;
}

}  // namespace lodestar
