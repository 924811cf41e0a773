// A piecewise constant density over the unit square, `rows` times `columns` equal cells: rows by the first coordinate,
// columns by the second. What is stored are the ends of the cells' intervals, and densities are differences of ends: so
// the density is that of what is sampled, whatever the weights were rounded to.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace lodestar {

class GridSquare {
 public:
  // Weights by row, then column: finite, >= 0, with a positive sum (checked).
  GridSquare(std::span<const double> weights, uint32_t rows, uint32_t columns);

  struct Drawn {
    Vec2 at;
    float density;  // Density(at)
    bool inside;    // so far from its cell's border that rounding cannot lead to a neighbour
  };
  // By inversion: rows by u.x, columns by u.y. u in [0, 1)^2 with 24 bits.
  Drawn Sample(Vec2 u) const {
    const Found row = Find(ends_.data(), rows_, u.x);
    const Found column = Find(ColumnEnds(row.index), columns_, u.y);
    const auto inside = [](float x) { return x > kBorder && x < 1 - kBorder; };
    return {{Along(row.index, row.inside, rows_), Along(column.index, column.inside, columns_)},
            Density(row.index, column.index),
            inside(row.inside) && inside(column.inside)};
  }
  // Per unit of area; `at` in [0, 1)^2.
  float Density(Vec2 at) const {
    const auto row = static_cast<uint32_t>(at.x * static_cast<float>(rows_));
    const auto column = static_cast<uint32_t>(at.y * static_cast<float>(columns_));
    return Density(row, column);
  }
  float greatest() const { return greatest_; }
  // A point of a cell, by where in [0, 1)^2 it lies within it.
  Vec2 PointIn(uint32_t cell, Vec2 inside) const {
    return {Along(cell / columns_, inside.x, rows_), Along(cell % columns_, inside.y, columns_)};
  }
  uint32_t rows() const { return rows_; }
  uint32_t columns() const { return columns_; }

 private:
  static constexpr float kBorder = 1e-3f;  // of a cell's side
  float Density(uint32_t row, uint32_t column) const {
    return Width(ends_.data(), row) * Width(ColumnEnds(row), column) * cells_;
  }
  struct Found {
    uint32_t index;
    float inside;
  };
  // The interval that holds u, never an empty one. Counting needs no branch.
  static Found Find(const float* ends, uint32_t n, float u) {
    uint32_t index = 0;
    for (uint32_t i = 0; i < n; i += 4)
      index += (ends[i] <= u) + (ends[i + 1] <= u) + (ends[i + 2] <= u) + (ends[i + 3] <= u);
    const float start = index > 0 ? ends[index - 1] : 0, width = ends[index] - start;
    return {index, std::min((u - start) / width, kOneMinusEpsilon)};
  }
  static float Along(uint32_t i, float inside, uint32_t n) {
    const float x = (static_cast<float>(i) + inside) / static_cast<float>(n);
    // Rounding up would move the point to the neighbour.
    const float end = static_cast<float>(i + 1) / static_cast<float>(n);
    return x < end ? x : std::nextafter(end, 0.0f);
  }

  static float Width(const float* ends, uint32_t i) { return i > 0 ? ends[i] - ends[i - 1] : ends[0]; }
  const float* ColumnEnds(uint32_t row) const { return &ends_[rows_ + row * columns_]; }

  uint32_t rows_, columns_;
  float cells_;              // their number
  std::vector<float> ends_;  // of the rows, then of the columns in each row
  float greatest_ = 0;
};

}  // namespace lodestar
