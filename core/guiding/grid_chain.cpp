#include "core/guiding/grid_chain.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace lodestar {
namespace {

// The cell beside, or the cell itself where the square ends.
uint32_t Beside(uint32_t cell, uint32_t which, uint32_t rows, uint32_t columns) {
  const uint32_t row = cell / columns, column = cell % columns;
  switch (which) {
    case 0:
      return row > 0 ? cell - columns : cell;
    case 1:
      return row + 1 < rows ? cell + columns : cell;
    case 2:
      return row * columns + (column + columns - 1) % columns;
    default:
      return row * columns + (column + 1) % columns;
  }
}

uint32_t Pick(float u, uint32_t n) {
  return std::min(static_cast<uint32_t>(u * static_cast<float>(n)), n - 1);
}

}  // namespace

uint32_t RunChain(std::span<const float> target, uint32_t rows, uint32_t columns, GridRandom& random) {
  uint32_t cell = Pick(random.Next2D().x, rows * columns);
  for (int step = 0; step < kChainSteps; ++step) {
    const Vec2 u = random.Next2D();
    const uint32_t next = u.x < kFarMove ? Pick(u.x / kFarMove, rows * columns)
                                         : Beside(cell, Pick((u.x - kFarMove) / (1 - kFarMove), 4), rows, columns);
    if (u.y * target[cell] < target[next] || target[cell] == 0) cell = next;
  }
  return cell;
}

// Far moves lead from every cell to every cell; in the order of the targets their sums are sums from both ends.
std::vector<double> ChainDistribution(std::span<const float> target, uint32_t rows, uint32_t columns) {
  const auto n = static_cast<uint32_t>(target.size());
  std::vector<uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return target[a] < target[b]; });
  const auto acceptance = [&](uint32_t from, uint32_t to) {
    return target[from] > target[to] ? double{target[to]} / target[from] : 1.0;
  };
  std::vector<double> p(n, 1.0 / n), next(n), above(n + 1);
  std::vector<double> leaving(n);  // the chance that a far move from a cell is accepted
  double below = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const double t = target[order[i]];
    leaving[order[i]] = (t > 0 ? below / t + (n - i) : n) / double(n);
    below += t;
  }
  for (int step = 0; step < kChainSteps; ++step) {
    above[n] = 0;  // of p / target over the cells of larger targets
    for (uint32_t i = n; i-- > 0;)
      above[i] = above[i + 1] + (target[order[i]] > 0 ? p[order[i]] / target[order[i]] : 0);
    double from_below = 0;  // all that have none leave for anywhere, each other included
    for (uint32_t cell = 0; cell < n; ++cell) from_below += target[cell] > 0 ? 0 : p[cell];
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t cell = order[i];
      if (target[cell] > 0) from_below += p[cell];
      const double arriving = (from_below + target[cell] * above[i + 1]) / n;
      next[cell] = p[cell] + kFarMove * (arriving - p[cell] * leaving[cell]);
    }
    for (uint32_t cell = 0; cell < n; ++cell)
      for (uint32_t which = 0; which < 4; ++which) {
        const uint32_t to = Beside(cell, which, rows, columns);
        const double moved = p[cell] * acceptance(cell, to) * ((1 - double{kFarMove}) / 4);
        next[cell] -= moved;
        next[to] += moved;
      }
    p.swap(next);
  }
  for (double& probability : p) probability = std::max(probability, 0.0);
  return p;
}

}  // namespace lodestar
