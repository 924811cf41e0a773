#include <cmath>

#include "core/base/check.h"
#include "core/guiding/reconstruction_shrinkage.h"

namespace lodestar::directional {
namespace {

// The weight of the unsmoothed tree: sqrt(kRawWeight) / (sqrt(kRawWeight) + sqrt(1 - kRawWeight)) = 0.37 is the least
// part of any cell's density that smoothing can leave.
constexpr double kRawWeight = 0.25;

// A cell of the tree as seen from a neighbour: the square next to it at its own depth, or the larger cell that holds
// that square.
struct Square {
  uint32_t slot = 0;
  bool mirrored = false;  // seen across a pole: x runs the other way
};
constexpr uint32_t kWhole = ~0u;  // slot of the whole square, above the root

class Smoother {
 public:
  Smoother(const CellMasses& masses, Shrinkage shrinkage)
      : nodes_(masses.nodes),
        node_count_(masses.node_count),
        share_(std::move(shrinkage.share)),
        weight_(std::move(shrinkage.weight)),
        density_(share_.size()),
        level_(node_count_, 0),
        around_(node_count_),
        smoothed_(share_.size()) {}

  // Masses of the cells; zero above them.
  std::vector<double> Smooth() {
    FindDensities();
    for (int i = 0; i < 9; ++i) around_[0][i] = {kWhole, i % 3 != 1};
    std::vector<double> mass(node_count_, 1);  // of the nodes
    for (uint32_t node = 0; node < node_count_; ++node) {
      const std::array<float, 4> predicted = Predict(node);
      const double in_node = (share_[node * 4] + share_[node * 4 + 1]) + (share_[node * 4 + 2] + share_[node * 4 + 3]);
      const double keep = in_node > 0 ? (1 - weight_[node]) / in_node : 0;
      const double shrink = in_node > 0 ? weight_[node] : 1;
      for (uint32_t c = 0; c < 4; ++c) {
        const uint32_t slot = node * 4 + c, child = nodes_[node].child[c];
        const double q = mass[node] * (keep * share_[slot] + shrink * predicted[c]);
        if (child != 0) {
          mass[child] = q;
        } else {
          smoothed_[slot] = std::sqrt(kRawWeight * share_[slot] * share_[slot] + (1 - kRawWeight) * q * q);
        }
      }
    }
    return std::move(smoothed_);
  }

 private:
  void FindDensities() {
    for (uint32_t node = 0; node < node_count_; ++node) {
      const float per_area = static_cast<float>(uint64_t{1} << (2 * (level_[node] + 1)));
      for (uint32_t c = 0; c < 4; ++c) {
        density_[node * 4 + c] = static_cast<float>(share_[node * 4 + c]) * per_area;
        if (nodes_[node].child[c] != 0) level_[nodes_[node].child[c]] = static_cast<uint8_t>(level_[node] + 1);
      }
    }
  }

  // The child square (x, y) of a square next to a node of `level`, or the square itself where it is a cell.
  Square Child(Square of, uint32_t x, uint32_t y, int level) const {
    const uint32_t node = of.slot == kWhole ? 0 : nodes_[of.slot / 4].child[of.slot % 4];
    if (node == 0 && of.slot != kWhole) return of;
    // Across a pole x is mirrored and phi turned by half a circle, which is the first bit of y.
    if (of.mirrored) {
      x ^= 1;
      y ^= level == 0;
    }
    return {node * 4 + x + 2 * y, of.mirrored};
  }

  // The children's shares as their surroundings predict them: the mean density over the 3 x 3 squares of their own size
  // around each, weights 1 2 1. Also finds the surroundings of the children that are nodes.
  std::array<float, 4> Predict(uint32_t node) {
    // The 4 x 4 squares of the children's size around the node.
    const std::array<Square, 9>& around = around_[node];
    std::array<std::array<Square, 4>, 4> grid;
    float d[4][4];
    for (uint32_t y = 0; y < 4; ++y) {
      for (uint32_t x = 0; x < 4; ++x) {
        grid[y][x] = Child(around[(y + 1) / 2 * 3 + (x + 1) / 2], (x + 1) & 1, (y + 1) & 1, level_[node]);
        d[y][x] = density_[grid[y][x].slot];
      }
    }
    float rows[4][2];
    for (int y = 0; y < 4; ++y) {
      rows[y][0] = d[y][0] + 2 * d[y][1] + d[y][2];
      rows[y][1] = d[y][1] + 2 * d[y][2] + d[y][3];
    }
    std::array<float, 4> predicted;
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t x = c & 1, y = c >> 1;
      predicted[c] = rows[y][x] + 2 * rows[y + 1][x] + rows[y + 2][x];
      const uint32_t child = nodes_[node].child[c];
      if (child == 0) continue;
      for (uint32_t i = 0; i < 9; ++i) around_[child][i] = grid[y + i / 3][x + i % 3];
    }
    const float sum = (predicted[0] + predicted[1]) + (predicted[2] + predicted[3]);
    for (float& p : predicted) p = sum > 0 ? p / sum : 0.25f;
    return predicted;
  }

  const DirectionalNode* nodes_;
  uint32_t node_count_;
  std::vector<double> share_;
  std::vector<float> weight_;
  std::vector<float> density_;                 // per slot, of the unit square
  std::vector<uint8_t> level_;                 // per node; the root's is 0
  std::vector<std::array<Square, 9>> around_;  // per node: the 3 x 3 squares of its size around it, itself the fifth
  std::vector<double> smoothed_;
};

}  // namespace

Tree ReconstructNative(const CellMasses& masses, double flux_threshold, int max_depth) {
  LODESTAR_CHECK(masses.total.size() == size_t{masses.node_count} * 4);
  if (!masses.halves[0].empty()) {
    Shrinkage shrinkage = InferShrinkage(masses);
    if (!shrinkage.weight.empty()) {
      std::vector<double> smoothed = Smoother(masses, std::move(shrinkage)).Smooth();
      return Rebuild(masses.nodes, masses.node_count, std::move(smoothed), flux_threshold, max_depth);
    }
  }
  return Rebuild(masses.nodes, masses.node_count, masses.total, flux_threshold, max_depth);
}

}  // namespace lodestar::directional
