#include "core/learning/round.h"

#include <algorithm>
#include <bit>

#include "core/base/check.h"

namespace lodestar {

uint32_t TreeNode::end(uint32_t unit_count) const {
  const uint64_t end = (uint64_t{index} + 1) << level;
  return static_cast<uint32_t>(std::min<uint64_t>(end, unit_count));
}

bool TreeNode::ValidIn(uint32_t unit_count) const {
  return unit_count > 0 && level <= Root(unit_count).level && uint64_t{index} << level < unit_count;
}

TreeNode TreeNode::Root(uint32_t unit_count) {
  LODESTAR_CHECK(unit_count > 0);
  return {static_cast<uint32_t>(std::bit_width(unit_count - 1)), 0};
}

std::string TreeNode::ToString() const {
  return "node " + std::to_string(index) + " of level " + std::to_string(level);
}

}  // namespace lodestar
