#include "core/guiding/tree_top.h"

namespace lodestar {

TreeTop::TreeTop(const DirectionalNode* nodes) {
  using product::kBlock, product::kSide;
  columns.fill(0);
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      uint32_t at = 0;
      bool exists = true;
      float share = 1;
      for (int shift = product::kBlockLevel - 1; shift >= 0; --shift) {
        const uint32_t c = ((x >> shift) & 1) + 2 * ((y >> shift) & 1);
        const DirectionalNode& n = exists ? nodes[at] : kUniformNode;
        share *= QuarterShares(n).p[c];
        at = n.child[c];
        exists = at != 0;
      }
      const uint32_t cell = y * kSide + x;
      flux[cell] = share;
      columns[x] += share;
      node[cell] = static_cast<uint16_t>(at);
    }
  }
}

}  // namespace lodestar
