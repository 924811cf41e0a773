// The third level of a D-tree laid out flat, so that a product with it need not collect it from up to 21 nodes at each
// vertex. 416 bytes a tree.
#pragma once

#include "core/guiding/directional_tree.h"
#include "core/guiding/product_cells.h"

namespace lodestar {

// A node whose children are equally likely cells: what a tree is taken to have below its own cells.
inline constexpr DirectionalNode kUniformNode;

// P(child) of a node, child by child. Adds up to 1 but for rounding.
struct QuarterShares {
  explicit QuarterShares(const DirectionalNode& node) {
    const float left = static_cast<float>(node.left) * 0x1p-15f, right = 1 - left;
    p[0] = left * (static_cast<float>(node.lower[0]) * 0x1p-15f);
    p[1] = right * (static_cast<float>(node.lower[1]) * 0x1p-15f);
    p[2] = left - p[0];
    p[3] = right - p[1];
  }
  float p[4];
};

struct TreeTop {
  // `nodes`: root first.
  explicit TreeTop(const DirectionalNode* nodes);
  // Fetches all of it at once.
  void Prefetch() const {
    for (size_t line = 0; line < sizeof(TreeTop); line += 64)
      __builtin_prefetch(reinterpret_cast<const char*>(this) + line);
  }

  product::Block flux;                         // the tree's probabilities of the cells
  std::array<float, product::kSide> columns;   // their sums over phi
  std::array<uint16_t, product::kBlock> node;  // of each cell's own subtree; 0: none
};

}  // namespace lodestar
