// Units, rounds, and the nodes of a round's reduction tree.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <vector>

namespace lodestar {

// A round is every unit once, for `passes` passes from `first_pass` on (passes count through the whole job, so a sample
// is named by its pixel and pass). Its size depends on the job alone, never on speed or workers.
struct Round {
  uint32_t iteration = 0;
  uint32_t index = 0;  // within the iteration
  uint32_t first_pass = 0, passes = 0;
  uint32_t unit_count = 0;
  bool record = true;  // false: nothing will be learned from this round, so nothing is recorded
  friend bool operator==(const Round&, const Round&) = default;
};

// A node of the binary tree over unit indices: the aligned block [index << level, (index + 1) << level), cut at
// unit_count.
struct TreeNode {
  uint32_t level = 0, index = 0;
  uint32_t first() const { return index << level; }
  uint32_t end(uint32_t unit_count) const;  // exclusive
  // False for blocks that start beyond the last unit or are larger than the root: to be asked before a node from
  // outside is used.
  bool ValidIn(uint32_t unit_count) const;
  bool Covers(TreeNode other) const { return other.level <= level && (other.index >> (level - other.level)) == index; }
  bool Overlaps(TreeNode other) const { return Covers(other) || other.Covers(*this); }
  TreeNode Parent() const { return {level + 1, index >> 1}; }
  TreeNode Child(int which) const { return {level - 1, index * 2 + static_cast<uint32_t>(which)}; }
  static TreeNode Root(uint32_t unit_count);  // the smallest node that covers every unit
  std::string ToString() const;
  auto operator<=>(const TreeNode&) const = default;
};

}  // namespace lodestar
