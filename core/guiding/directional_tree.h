// One D-tree: a quadtree over the cylindrical equal-area square (cos theta + 1) / 2, phi / 2 pi (Mueller et al. 2017,
// section 3.1).
//
// A tree is a run of nodes, root first; all functions take a pointer to the root. Child c = x + 2 y, x the half in cos
// theta, y the half in phi. A slot is 4 node + c: what a cell is recorded under, too. Nodes are laid out depth first,
// likeliest child first, so that the descents that are made most often run along consecutive cache lines; four nodes
// share one line.
//
// Probabilities are integers of 15 bits, conditional: that of the lower half in cos theta, then that of the lower half
// in phi given the former. So each node is a distribution exactly, whatever its bits, and a descent is integer
// arithmetic without rounding to guard against.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/math/warp.h"

namespace lodestar {

struct alignas(16) DirectionalNode {
  static constexpr uint32_t kOne = 1 << 15;
  uint16_t left = kOne / 2;                              // P(x half 0) * kOne
  std::array<uint16_t, 2> lower = {kOne / 2, kOne / 2};  // P(y half 0 | x half) * kOne
  std::array<uint16_t, 4> child = {0, 0, 0, 0};          // index in the tree's run; 0: none, the child is a cell
  uint16_t unused = 0;

  // P(child) * 2^30.
  uint32_t Share(uint32_t c) const {
    // Without branches: c is random by design.
    const uint32_t x = c & 1, y = c >> 1;
    const uint32_t low = lower[0] ^ ((lower[0] ^ lower[1]) & -x);
    return (left + ((kOne - 2u * left) & -x)) * (low + ((kOne - 2u * low) & -y));
  }
  float Probability(uint32_t c) const { return static_cast<float>(Share(c)) * 0x1p-30f; }
};
static_assert(sizeof(DirectionalNode) == 16);

namespace directional {

inline constexpr int kMaxDepth = 20;
inline constexpr uint32_t kMaxNodes = 65535;  // of one tree: links have 16 bits
inline constexpr int kBits = 24;              // square coordinates as integers: every float in [0, 1) has a cell

struct Cell {
  uint32_t slot;
  int depth;      // 1 for a cell of the root node
  float density;  // 1 / sr
};

inline uint32_t ToInteger(float coordinate) {
  return static_cast<uint32_t>(coordinate * static_cast<float>(1 << kBits));
}

// Fetches the lines that most descents run along, all at once instead of one after the other: 12 hold half of a tree of
// some hundred nodes (measured against 4 and 8 by guiding_bench).
inline void Prefetch(const DirectionalNode* nodes) {
  for (int line = 0; line < 12; ++line) __builtin_prefetch(nodes + line * 4);
}

inline Cell Locate(const DirectionalNode* nodes, uint32_t x, uint32_t y) {
  float density = kUniformSpherePdf;
  uint32_t node = 0;
  Prefetch(nodes);
  for (int shift = kBits - 1;; --shift) {
    const uint32_t c = ((x >> shift) & 1) | (((y >> shift) & 1) << 1);
    density *= static_cast<float>(static_cast<int32_t>(nodes[node].Share(c))) * 0x1p-28f;
    const uint32_t child = nodes[node].child[c];
    if (child == 0) return {node * 4 + c, kBits - shift, density};
    node = child;
  }
}
inline Cell Locate(const DirectionalNode* nodes, Vec2 square) {
  return Locate(nodes, ToInteger(square.x), ToInteger(square.y));
}

struct Point {
  Vec2 square;
  float density;     // the cell's; equals Locate(square).density
  bool near_border;  // a direction and back may end in another cell
  Vec2 inner;        // another point of the cell, uniform in its central half, for where `square` rounds out of it
};

// How far DirectionToCylindrical(CylindricalToDirection(s)) strays from s at most, with a factor of two to spare
// (tests/guiding).
inline constexpr float kRoundTrip = 5e-7f;

// Hierarchical warping: u.x chooses the halves in cos theta, u.y those in phi given the former, so stratified u stay
// stratified. Each is an integer within a range that narrows as in arithmetic decoding: x < range always holds, so a
// half of probability zero is never entered. u has 24 bits; a hash fills 24 more, which a deep descent would otherwise
// find empty.
inline Point Sample(const DirectionalNode* nodes, Vec2 u) {
  const uint64_t ux = ToInteger(u.x), uy = ToInteger(u.y);
  const uint64_t low = ((ux << 32) | uy) * 0x9e3779b97f4a7c15ULL;
  uint64_t x = (ux << 24) | (low >> 40), y = (uy << 24) | ((low >> 16) & 0xffffff);
  uint64_t x_range = uint64_t{1} << 48, y_range = uint64_t{1} << 48;
  float density = kUniformSpherePdf;
  uint32_t node = 0, ix = 0, iy = 0;
  int depth = 0;
  Prefetch(nodes);
  do {
    const DirectionalNode& n = nodes[node];
    // Masks, not branches: the outcomes are random by design. Both columns' decisions in y are made while that in x is,
    // which leaves one multiplication and comparison between a node and its child.
    const uint64_t x_split = (x_range * n.left) >> 15, y_split0 = (y_range * n.lower[0]) >> 15,
                   y_split1 = (y_range * n.lower[1]) >> 15;
    uint64_t children;
    std::memcpy(&children, n.child.data(), sizeof(children));
    const uint64_t by0 = y >= y_split0, by1 = y >= y_split1;
    const uint64_t bx = x >= x_split, x_mask = -bx;
    const uint64_t by = by0 ^ ((by0 ^ by1) & bx), y_mask = -by;
    const uint32_t c = static_cast<uint32_t>(bx + 2 * by);
    node = static_cast<uint32_t>(children >> (16 * c)) & 0xffff;
    x -= x_split & x_mask;
    x_range = x_split + ((x_range - 2 * x_split) & x_mask);
    const uint64_t y_split = y_split0 ^ ((y_split0 ^ y_split1) & x_mask);
    y -= y_split & y_mask;
    y_range = y_split + ((y_range - 2 * y_split) & y_mask);
    ix = ix * 2 + static_cast<uint32_t>(bx);
    iy = iy * 2 + static_cast<uint32_t>(by);
    density *= static_cast<float>(static_cast<int32_t>(n.Share(c))) * 0x1p-28f;
    ++depth;
  } while (node != 0);
  const float size = std::bit_cast<float>(static_cast<uint32_t>(127 - depth) << 23);
  const float fx = static_cast<float>(static_cast<int64_t>(x)) / static_cast<float>(static_cast<int64_t>(x_range));
  const float fy = static_cast<float>(static_cast<int64_t>(y)) / static_cast<float>(static_cast<int64_t>(y_range));
  const float margin = std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy)) * size;
  const float cx = static_cast<float>(ix), cy = static_cast<float>(iy);
  return {{std::min((cx + fx) * size, kOneMinusEpsilon), std::min((cy + fy) * size, kOneMinusEpsilon)},
          density,
          !(margin > kRoundTrip),
          {(cx + 0.25f + 0x1p-9f * static_cast<float>(low & 0xff)) * size,
           (cy + 0.25f + 0x1p-9f * static_cast<float>((low >> 8) & 0xff)) * size}};
}

namespace detail {

// Adds the part of the cell-sized square at (from_x, from_y) that the rectangle covers, where the tree is finer than
// it.
template <class Add>
void Splat(const DirectionalNode* nodes, uint32_t node, uint32_t node_x, uint32_t node_y, int shift,
           const std::array<uint32_t, 4>& r, float scale, Add& add) {
  const uint32_t half = uint32_t{1} << shift;
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t cx = node_x + (c & 1 ? half : 0), cy = node_y + (c & 2 ? half : 0);
    const uint32_t x0 = std::max(cx, r[0]), x1 = std::min(cx + half, r[2]), y0 = std::max(cy, r[1]),
                   y1 = std::min(cy + half, r[3]);
    if (x0 >= x1 || y0 >= y1) continue;
    if (nodes[node].child[c] != 0) {
      Splat(nodes, nodes[node].child[c], cx, cy, shift - 1, r, scale, add);
    } else {
      add(node * 4 + c, static_cast<float>(x1 - x0) * static_cast<float>(y1 - y0) * scale);
    }
  }
}

}  // namespace detail

// Calls add(slot, share) for every cell under a footprint of the size of `cell` around (x, y), which lies in it. A slot
// can come more than once. The footprint wraps around in phi; at the poles it is moved inside, so the shares always sum
// to 1.
template <class Add>
void ForFootprint(const DirectionalNode* nodes, uint32_t x, uint32_t y, const Cell& cell, Add&& add) {
  constexpr uint32_t kEnd = uint32_t{1} << kBits;
  const uint32_t size = kEnd >> cell.depth, low = size - 1;
  const float scale = 1 / (static_cast<float>(size) * static_cast<float>(size));  // a power of two
  const uint32_t x0 = std::min(x - std::min(x, size / 2), kEnd - size), y0 = (y - size / 2) & (kEnd - 1);
  // The footprint covers parts of up to four squares of its own size on the grid. Each is within one cell, or is a node
  // whose subtree is walked.
  for (uint32_t quarter = 0; quarter < 4; ++quarter) {
    const uint32_t square_x = (x0 & ~low) + (quarter & 1 ? size : 0),
                   square_y = ((y0 & ~low) + (quarter & 2 ? size : 0)) & (kEnd - 1);
    const uint32_t from_x = quarter & 1 ? 0 : x0 & low, from_y = quarter & 2 ? 0 : y0 & low;
    const uint32_t to_x = quarter & 1 ? x0 & low : size, to_y = quarter & 2 ? y0 & low : size;
    if (from_x >= to_x || from_y >= to_y) continue;
    const float share = static_cast<float>(to_x - from_x) * static_cast<float>(to_y - from_y) * scale;
    if (square_x == (x & ~low) && square_y == (y & ~low)) {
      add(cell.slot, share);
      continue;
    }
    uint32_t node = 0;
    for (int shift = kBits - 1;; --shift) {
      const uint32_t c = ((square_x >> shift) & 1) | (((square_y >> shift) & 1) << 1);
      const uint32_t child = nodes[node].child[c];
      if (child == 0) {
        add(node * 4 + c, share);
        break;
      }
      node = child;
      if (shift == kBits - cell.depth) {
        detail::Splat(nodes, node, square_x, square_y, shift - 1,
                      {square_x + from_x, square_y + from_y, square_x + to_x, square_y + to_y}, scale, add);
        break;
      }
    }
  }
}

// The order in which a node's subtrees are laid out: by probability, ties by index. A function of the stored integers
// alone, so that the serial form needs no links.
std::array<int, 4> LikeliestFirst(const DirectionalNode& node);

struct Tree {
  std::vector<DirectionalNode> nodes;
  int depth = 0;
};

// The tree of the next iteration. `masses` are per slot of `nodes`. A cell above `flux_threshold` of the total splits,
// its children a quarter each, recursively; an inner node with no more becomes a cell. Level by level: where kMaxNodes
// are not enough, the finest cells are left whole. Total > 0, masses finite and not negative.
Tree Rebuild(const DirectionalNode* nodes, uint32_t node_count, std::vector<double> masses, double flux_threshold,
             int max_depth);

}  // namespace directional
}  // namespace lodestar
