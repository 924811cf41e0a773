// The committed part of a round: an antichain of tree nodes with their contributions, merged along the fixed tree
// whoever computed them and in whatever order they came (DESIGN: docs/architecture.md, "The contract").
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "core/learning/method.h"

namespace lodestar {

class RoundReduction {
 public:
  explicit RoundReduction(uint32_t unit_count);

  enum class Outcome { kCommitted, kCovered };
  // Drops a node that is covered already; replaces descendants of an ancestor; merges siblings upward as far as both
  // are there.
  Outcome Commit(TreeNode node, Contribution contribution);
  bool Covered(TreeNode node) const;
  bool Complete() const;
  std::vector<TreeNode> Nodes() const;  // the antichain, ascending by first unit
  // Units not covered yet, as maximal aligned nodes of at most `max_level`.
  std::vector<TreeNode> Missing(uint32_t max_level) const;
  uint32_t committed_units() const { return committed_units_; }
  const std::map<TreeNode, Contribution>& parts() const { return parts_; }  // for checkpoints
  // The root's contribution; only when Complete().
  Contribution Take();

 private:
  uint32_t unit_count_;
  uint32_t committed_units_ = 0;
  std::map<TreeNode, Contribution> parts_;
};

}  // namespace lodestar
