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
  Smoother(const CellMasses& masses, const Shrinkage& shrinkage)
      : nodes_(masses.nodes),
        share_(shrinkage.share),
        weight_(shrinkage.weight),
        density_(share_.size()),
        around_(masses.node_count) {}

  // Masses of the cells; zero above them.
  std::vector<double> Smooth() {
    struct Pending {
      uint32_t node;
      int level;  // the root's is 0
      double mass;
    };
    std::vector<double> smoothed(share_.size());
    // Level by level: what is around a node is smoothed before what lies in it.
    std::vector<Pending> queue = {{0, 0, 1.0}};
    for (int i = 0; i < 9; ++i) around_[0][i] = {kWhole, i % 3 != 1};
    for (size_t next = 0; next < queue.size(); ++next) {
      const auto [node, level, mass] = queue[next];
      const std::array<float, 4> predicted = Predict(around_[node]);
      const double* const share = &share_[node * 4];
      const double recorded = (share[0] + share[1]) + (share[2] + share[3]);
      const double keep = recorded > 0 ? (1 - weight_[node]) / recorded : 0;
      const double shrink = recorded > 0 ? weight_[node] : 1;
      const auto per_area = static_cast<double>(uint64_t{1} << (2 * (level + 1)));
      for (uint32_t c = 0; c < 4; ++c) {
        const uint32_t slot = node * 4 + c, child = nodes_[node].child[c];
        const double q = mass * (keep * share[c] + shrink * predicted[c]);
        density_[slot] = static_cast<float>(q * per_area);
        if (child != 0) {
          queue.push_back({child, level + 1, q});
          for (uint32_t i = 0; i < 9; ++i) {
            const uint32_t x = (c & 1) + i % 3 + 1, y = (c >> 1) + i / 3 + 1;  // in children, from two before the node
            around_[child][i] = Child(around_[node][y / 2 * 3 + x / 2], x & 1, y & 1, level);
          }
        } else {
          smoothed[slot] = std::sqrt(kRawWeight * share[c] * share[c] + (1 - kRawWeight) * q * q);
        }
      }
    }
    return smoothed;
  }

 private:
  using Surroundings = std::array<Square, 9>;  // the 3 x 3 squares of a node's size around it, itself the fifth

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

  float Density(Square square) const { return square.slot == kWhole ? 1 : density_[square.slot]; }

  // The shares of a node's children if the density were bilinear between the centres of the squares around it.
  std::array<float, 4> Predict(const Surroundings& around) const {
    std::array<float, 4> predicted;
    for (int c = 0; c < 4; ++c) {
      const int x = c & 1 ? 5 : 3, y = c & 2 ? 7 : 1, xy = x + y - 4;
      predicted[c] = 9 * Density(around[4]) + 3 * (Density(around[x]) + Density(around[y])) + Density(around[xy]);
    }
    const float sum = (predicted[0] + predicted[1]) + (predicted[2] + predicted[3]);
    for (float& p : predicted) p = sum > 0 ? p / sum : 0.25f;
    return predicted;
  }

  const DirectionalNode* nodes_;
  const std::vector<double>& share_;
  const std::vector<float>& weight_;
  std::vector<float> density_;  // per slot, smoothed, of the unit square
  std::vector<Surroundings> around_;
};

}  // namespace

Tree ReconstructNative(const CellMasses& masses, double flux_threshold, int max_depth) {
  LODESTAR_CHECK(masses.total.size() == size_t{masses.node_count} * 4);
  if (!masses.halves[0].empty()) {
    const Shrinkage shrinkage = InferShrinkage(masses);
    if (!shrinkage.weight.empty())
      return Rebuild(masses.nodes, masses.node_count, Smoother(masses, shrinkage).Smooth(), flux_threshold, max_depth);
  }
  return Rebuild(masses.nodes, masses.node_count, masses.total, flux_threshold, max_depth);
}

}  // namespace lodestar::directional
