#include "core/learning/reduction.h"

#include <algorithm>
#include <functional>

#include "core/base/check.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

using Parts = std::map<TreeNode, Contribution>;

// The parts strictly below `node` on one level are neighbours in the map.
std::pair<Parts::const_iterator, Parts::const_iterator> Below(const Parts& parts, TreeNode node, uint32_t level) {
  const uint32_t shift = node.level - level;
  const uint64_t end = (uint64_t{node.index} + 1) << shift;
  const auto first = parts.lower_bound({level, node.index << shift});
  const auto last =
      end > ~0u ? parts.lower_bound({level + 1, 0}) : parts.lower_bound({level, static_cast<uint32_t>(end)});
  return {first, last};
}

bool AnyBelow(const Parts& parts, TreeNode node) {
  for (uint32_t level = 0; level < node.level; ++level) {
    const auto [first, last] = Below(parts, node, level);
    if (first != last) return true;
  }
  return false;
}

}  // namespace

RoundReduction::RoundReduction(uint32_t unit_count) : unit_count_(unit_count) {
  LODESTAR_CHECK(unit_count > 0);
}

bool RoundReduction::Covered(TreeNode node) const {
  const uint32_t root = TreeNode::Root(unit_count_).level;
  for (; node.level <= root; node = node.Parent()) {
    if (parts_.contains(node)) return true;
  }
  return false;
}

RoundReduction::Outcome RoundReduction::Commit(TreeNode node, Contribution contribution) {
  if (!node.ValidIn(unit_count_)) {
    throw Error(ErrorKind::kInvalidInput,
                node.ToString() + " does not exist in a round of " + std::to_string(unit_count_) + " units");
  }
  if (Covered(node)) return Outcome::kCovered;

  // An ancestor replaces its descendants: it holds the same work again.
  for (uint32_t level = 0; level < node.level; ++level) {
    const auto [first, last] = Below(parts_, node, level);
    for (auto it = first; it != last; ++it) committed_units_ -= it->first.end(unit_count_) - it->first.first();
    parts_.erase(first, last);
  }
  committed_units_ += node.end(unit_count_) - node.first();

  // Upward while the sibling is there, or lies beyond the last unit and has nothing to add.
  const TreeNode root = TreeNode::Root(unit_count_);
  while (node != root) {
    const TreeNode sibling{node.level, node.index ^ 1};
    if (sibling.ValidIn(unit_count_)) {
      const auto found = parts_.find(sibling);
      if (found == parts_.end()) break;
      Contribution other = std::move(found->second);
      parts_.erase(found);
      if (sibling.index < node.index) std::swap(contribution, other);
      contribution.Merge(std::move(other));
    }
    node = node.Parent();
  }
  parts_.emplace(node, std::move(contribution));
  return Outcome::kCommitted;
}

bool RoundReduction::Complete() const {
  return committed_units_ == unit_count_;
}

std::vector<TreeNode> RoundReduction::Nodes() const {
  std::vector<TreeNode> nodes;
  nodes.reserve(parts_.size());
  for (const auto& [node, contribution] : parts_) nodes.push_back(node);
  std::sort(nodes.begin(), nodes.end(), [](TreeNode a, TreeNode b) { return a.first() < b.first(); });
  return nodes;
}

std::vector<TreeNode> RoundReduction::Missing(uint32_t max_level) const {
  std::vector<TreeNode> missing;
  const std::function<void(TreeNode)> visit = [&](TreeNode node) {
    if (!node.ValidIn(unit_count_) || parts_.contains(node)) return;
    if (node.level <= max_level && !AnyBelow(parts_, node)) {
      missing.push_back(node);
      return;
    }
    LODESTAR_CHECK(node.level > 0);
    visit(node.Child(0));
    visit(node.Child(1));
  };
  visit(TreeNode::Root(unit_count_));
  return missing;
}

Contribution RoundReduction::Take() {
  LODESTAR_CHECK(Complete() && parts_.size() == 1);
  Contribution root = std::move(parts_.begin()->second);
  parts_.clear();
  committed_units_ = 0;
  return root;
}

}  // namespace lodestar
