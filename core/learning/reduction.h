// The committed part of a round: which units are there, and all that they brought, merged as it came, by whoever
// computed it and in whatever order (DESIGN: docs/architecture.md, "The contract").
#pragma once

#include <span>
#include <vector>

#include "core/learning/method.h"

namespace lodestar {

class RoundReduction {
 public:
  // Of a round under `state`; `method` lives longer.
  RoundReduction(const Method& method, std::shared_ptr<const State> state, const TileGrid& grid, const Round& round);

  // kCovered: some of its units are there already, so all of it is dropped; those that are missing stay so.
  enum class Outcome { kCommitted, kCovered };
  // `bytes`: from SerializeContribution(). Statistics are added straight to those that are there. Throws and changes
  // nothing: Error(kCorrupt) for anything that is not a contribution of exactly these nodes, and where statistics are
  // missing that the round is to learn from; kInvalidInput for a node that the round does not have; kConflict for bytes
  // of another version and for statistics of another state.
  Outcome Commit(std::span<const TreeNode> nodes, std::string_view bytes);

  bool Covered(TreeNode node) const;  // all of it
  bool Complete() const { return committed_units() == units(); }
  // Maximal ones that are covered, ascending.
  std::vector<TreeNode> Nodes() const { return Maximal(TreeNode::Root(units()).level, true); }
  // Units not covered yet, as maximal aligned nodes of at most `max_level`.
  std::vector<TreeNode> Missing(uint32_t max_level) const { return Maximal(max_level, false); }
  uint32_t committed_units() const { return CoveredUnits(TreeNode::Root(units())); }
  const Contribution& merged() const { return merged_; }  // of Nodes(), for checkpoints
  Contribution Take();                                    // only when Complete()

 private:
  uint32_t units() const { return static_cast<uint32_t>(covered_.size()); }
  uint32_t CoveredUnits(TreeNode node) const;
  std::vector<TreeNode> Maximal(uint32_t max_level, bool covered) const;
  bool Refuses(std::span<const TreeNode> nodes) const;
  void Cover(TreeNode node);

  const Method& method_;
  std::shared_ptr<const State> state_;
  TileGrid grid_;
  Round round_;
  std::vector<bool> covered_;  // by unit
  Contribution merged_;
};

}  // namespace lodestar
