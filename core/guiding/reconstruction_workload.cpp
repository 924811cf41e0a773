#include <algorithm>
#include <numeric>

#include "core/guiding/reconstruction.h"

namespace lodestar::directional {

std::vector<uint8_t> WithinWorkload(std::span<const int> depths, int iteration) {
  constexpr int kDeepest = 10;
  double left = std::ldexp(1.5e7, iteration);
  std::array<double, kDeepest + 1> elements = {};  // of all layers of a tree
  for (int depth = kMinDenseDepth; depth <= kDeepest; ++depth)
    elements[depth] = elements[depth - 1] + std::ldexp(1.0, 2 * depth);

  std::vector<uint32_t> order(depths.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return depths[a] < depths[b]; });
  std::vector<uint8_t> taken(depths.size(), 0);
  for (uint32_t tree : order) {
    const int depth = depths[tree];
    if (depth > kDeepest || elements[depth] > left) break;
    if (depth < kMinDenseDepth) continue;  // no layer to blur
    left -= elements[depth];
    taken[tree] = 1;
  }
  return taken;
}

}  // namespace lodestar::directional
