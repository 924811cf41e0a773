#include "core/learning/reduction.h"

#include <algorithm>
#include <functional>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/learning/contribution.h"

namespace lodestar {

RoundReduction::RoundReduction(const Method& method, std::shared_ptr<const State> state, const TileGrid& grid,
                               const Round& round)
    : method_(method), state_(std::move(state)), grid_(grid), round_(round), covered_(round.unit_count) {
  LODESTAR_CHECK(round.unit_count > 0);
}

uint32_t RoundReduction::CoveredUnits(TreeNode node) const {
  return static_cast<uint32_t>(std::count(covered_.begin() + node.first(), covered_.begin() + node.end(units()), true));
}

bool RoundReduction::Covered(TreeNode node) const {
  return CoveredUnits(node) == node.end(units()) - node.first();
}

// What a part would add twice cannot be taken back out of the sums.
bool RoundReduction::Refuses(std::span<const TreeNode> nodes) const {
  for (const TreeNode node : nodes) {
    if (!node.ValidIn(units())) {
      throw Error(ErrorKind::kInvalidInput,
                  node.ToString() + " does not exist in a round of " + std::to_string(units()) + " units");
    }
  }
  return std::ranges::any_of(nodes, [&](TreeNode node) { return CoveredUnits(node) > 0; });
}

void RoundReduction::Cover(TreeNode node) {
  std::fill(covered_.begin() + node.first(), covered_.begin() + node.end(units()), true);
}

RoundReduction::Outcome RoundReduction::Commit(std::span<const TreeNode> nodes, std::string_view bytes) {
  if (Refuses(nodes)) return Outcome::kCovered;
  ReceivedContribution received = ReadContribution(grid_, round_, nodes, bytes);
  if (received.statistics) {
    AddStatistics(method_, state_, *received.statistics, &merged_.statistics);
  } else if (round_.record && (merged_.statistics || method_.NewStatistics(state_))) {
    // Units that met nothing send sums of nothing.
    throw Error(ErrorKind::kCorrupt, "contribution of " + nodes.front().ToString() +
                                         " carries no statistics, but something is learned from its round");
  }
  merged_.Merge(std::move(received.rest));
  for (const TreeNode node : nodes) Cover(node);
  return Outcome::kCommitted;
}

// The maximal nodes of at most `max_level` of which all units are covered, or none.
std::vector<TreeNode> RoundReduction::Maximal(uint32_t max_level, bool covered) const {
  std::vector<TreeNode> nodes;
  const std::function<void(TreeNode)> visit = [&](TreeNode node) {
    if (!node.ValidIn(units())) return;
    const uint32_t size = node.end(units()) - node.first(),
                   wanted = covered ? CoveredUnits(node) : size - CoveredUnits(node);
    if (wanted == 0) return;
    if (wanted == size && node.level <= max_level) {
      nodes.push_back(node);
      return;
    }
    visit(node.Child(0));
    visit(node.Child(1));
  };
  visit(TreeNode::Root(units()));
  return nodes;
}

Contribution RoundReduction::Take() {
  LODESTAR_CHECK(Complete());
  covered_.assign(covered_.size(), false);
  return std::exchange(merged_, {});
}

}  // namespace lodestar
