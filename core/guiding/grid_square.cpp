#include "core/guiding/grid_square.h"

#include "core/base/check.h"

namespace lodestar {
namespace {

// The ends of intervals as long as the weights; even where all are zero. From the last positive weight on they are 1,
// so that no u reaches a cell without any.
void Accumulate(std::span<const double> weights, float* ends) {
  const size_t n = weights.size();
  double total = 0, sum = 0;
  for (const double w : weights) total += w;
  for (size_t i = 0; i < n; ++i) {
    sum += weights[i];
    ends[i] = static_cast<float>(total > 0 ? sum / total : static_cast<double>(i + 1) / static_cast<double>(n));
  }
  for (size_t i = n; i-- > 0;) {
    ends[i] = 1;
    if (total == 0 || weights[i] > 0) break;
  }
}

}  // namespace

GridSquare::GridSquare(std::span<const double> weights, uint32_t rows, uint32_t columns)
    : rows_(rows), columns_(columns), cells_(static_cast<float>(rows * columns)), ends_(rows + weights.size()) {
  LODESTAR_CHECK(weights.size() == size_t{rows} * columns && rows % 4 == 0 && columns % 4 == 0);
  std::vector<double> sums(rows);
  double total = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    LODESTAR_CHECK(weights[i] >= 0 && std::isfinite(weights[i]));
    sums[i / columns] += weights[i];
    total += weights[i];
  }
  LODESTAR_CHECK(total > 0 && std::isfinite(total));
  Accumulate(sums, ends_.data());
  for (uint32_t row = 0; row < rows; ++row) {
    float* ends = &ends_[rows + row * columns];
    Accumulate(weights.subspan(size_t{row} * columns, columns), ends);
    for (uint32_t column = 0; column < columns; ++column)
      greatest_ = std::max(greatest_, Width(ends_.data(), row) * Width(ends, column) * cells_);
  }
}

}  // namespace lodestar
