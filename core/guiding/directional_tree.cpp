#include "core/guiding/directional_tree.h"

#include <array>

namespace lodestar::directional {
namespace {

// a / (a + b) in units of 1 / kOne. What is possible stays possible, and what is impossible so.
uint16_t Portion(double a, double b) {
  constexpr double kOne = DirectionalNode::kOne;
  if (!(a + b > 0)) return DirectionalNode::kOne / 2;
  double portion = std::floor(a / (a + b) * kOne + 0.5);
  if (a > 0) portion = std::max(portion, 1.0);
  if (b > 0) portion = std::min(portion, kOne - 1);
  return static_cast<uint16_t>(portion);
}

class Builder {
 public:
  Builder(const DirectionalNode* old, const std::vector<double>& masses, double threshold, int max_depth)
      : old_(old), masses_(masses), threshold_(threshold), max_depth_(max_depth) {}

  Tree Build() {
    Emit(0, true, {masses_[0], masses_[1], masses_[2], masses_[3]}, 0);
    return std::move(tree_);
  }

 private:
  // Appends a node at `depth` with the children's masses and then its subtrees. `old` is the node's index in the old
  // tree, if it existed.
  uint32_t Emit(uint32_t old, bool existed, const std::array<double, 4>& mass, int depth) {
    const uint32_t index = static_cast<uint32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    tree_.depth = std::max(tree_.depth, depth + 1);
    DirectionalNode node;
    node.left = Portion(mass[0] + mass[2], mass[1] + mass[3]);
    node.lower = {Portion(mass[0], mass[2]), Portion(mass[1], mass[3])};
    std::array<int, 4> order = LikeliestFirst(node);
    for (int c : order) {
      if (!(mass[c] > threshold_) || depth + 1 >= max_depth_ || tree_.nodes.size() >= kMaxNodes) continue;
      const uint32_t old_child = existed ? old_[old].child[c] : 0;
      std::array<double, 4> masses;
      for (uint32_t i = 0; i < 4; ++i) masses[i] = old_child != 0 ? masses_[old_child * 4 + i] : mass[c] * 0.25;
      node.child[c] = static_cast<uint16_t>(Emit(old_child, old_child != 0, masses, depth + 1));
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
  const std::array<uint32_t, 4> share = {node.Share(0), node.Share(1), node.Share(2), node.Share(3)};
  std::array<int, 4> order = {0, 1, 2, 3};
  for (int i = 1; i < 4; ++i) {
    for (int j = i; j > 0 && share[order[j]] > share[order[j - 1]]; --j) std::swap(order[j], order[j - 1]);
  }
  return order;
}

Tree Rebuild(const DirectionalNode* nodes, uint32_t node_count, std::vector<double> masses, double flux_threshold,
             int max_depth) {
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
