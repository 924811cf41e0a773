#include "core/guiding/directional_tree.h"

#include <array>

namespace lodestar::directional {
namespace {

class Builder {
 public:
  Builder(const DirectionalNode* old, const std::vector<double>& masses, double threshold, int max_depth)
      : old_(old), masses_(masses), threshold_(threshold), max_depth_(max_depth) {}

  Tree Build() {
    Emit(0, true, {masses_[0], masses_[1], masses_[2], masses_[3]}, 0);
    return std::move(tree_);
  }

 private:
  // Appends a node at `depth` with the children's masses and then its subtrees. `old` is the node's index in the old tree, if it existed.
  uint32_t Emit(uint32_t old, bool existed, const std::array<double, 4>& mass, int depth) {
    const uint32_t index = static_cast<uint32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    tree_.depth = std::max(tree_.depth, depth + 1);
    const double total = mass[0] + mass[1] + mass[2] + mass[3];
    DirectionalNode node;
    for (int c = 0; c < 4; ++c) node.probability[c] = static_cast<float>(mass[c] / total);
    std::array<int, 4> order = LikeliestFirst(node);
    for (int c : order) {
      if (!(mass[c] > threshold_) || depth + 1 >= max_depth_) continue;
      const uint32_t old_child = existed ? old_[old].child[c] : 0;
      std::array<double, 4> masses;
      for (uint32_t i = 0; i < 4; ++i) masses[i] = old_child != 0 ? masses_[old_child * 4 + i] : mass[c] * 0.25;
      node.child[c] = Emit(old_child, old_child != 0, masses, depth + 1);
    }
    tree_.nodes[index] = node;
    return index;
  }

  const DirectionalNode* old_;
  const std::vector<double>& masses_;
  double threshold_;
  int max_depth_;
  Tree tree_;
};

}  // namespace

std::array<int, 4> LikeliestFirst(const DirectionalNode& node) {
  std::array<int, 4> order = {0, 1, 2, 3};
  for (int i = 1; i < 4; ++i) {
    for (int j = i; j > 0 && node.probability[order[j]] > node.probability[order[j - 1]]; --j) std::swap(order[j], order[j - 1]);
  }
  return order;
}

Tree Rebuild(const DirectionalNode* nodes, uint32_t node_count, std::vector<double> masses, double flux_threshold, int max_depth) {
  // Children come after their parents, so one sweep from the end sums every inner node.
  for (uint32_t node = node_count; node-- > 0;) {
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t child = nodes[node].child[c];
      if (child == 0) continue;
      masses[node * 4 + c] += masses[child * 4] + masses[child * 4 + 1] + masses[child * 4 + 2] + masses[child * 4 + 3];
    }
  }
  const double total = masses[0] + masses[1] + masses[2] + masses[3];
  return Builder(nodes, masses, flux_threshold * total, max_depth).Build();
}

}  // namespace lodestar::directional
