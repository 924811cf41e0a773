// One D-tree: a quadtree over the cylindrical equal-area square (cos theta + 1) / 2, phi / 2 pi (Mueller et al. 2017, section 3.1).
//
// A tree is a run of nodes, root first; all functions take a pointer to the root. A child is x + 2 y, x the half in cos theta, y the half
// in phi. A slot is 4 node + child: what a cell is recorded under, too. Children follow their parent depth first, likeliest child
// first, so that the descents that are made most often run along consecutive cache lines.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/base/hash.h"
#include "core/math/warp.h"

namespace lodestar {

struct alignas(32) DirectionalNode {
  float probability[4] = {0.25f, 0.25f, 0.25f, 0.25f};  // of each child, given the node; they sum to 1
  uint32_t child[4] = {0, 0, 0, 0};                      // index in the tree's run; 0: none, the child is a cell
};
static_assert(sizeof(DirectionalNode) == 32);

namespace directional {

inline constexpr int kMaxDepth = 20;
inline constexpr int kBits = 24;  // square coordinates as integers: every float in [0, 1) has a cell

struct Cell {
  uint32_t slot;
  int depth;      // 1 for a cell of the root node
  float density;  // 1 / sr
};

inline uint32_t ToInteger(float coordinate) { return static_cast<uint32_t>(coordinate * static_cast<float>(1 << kBits)); }

inline Cell Locate(const DirectionalNode* nodes, uint32_t x, uint32_t y) {
  float density = kUniformSpherePdf;
  uint32_t node = 0;
  for (int shift = kBits - 1;; --shift) {
    const uint32_t c = ((x >> shift) & 1) | (((y >> shift) & 1) << 1);
    density *= 4 * nodes[node].probability[c];
    const uint32_t child = nodes[node].child[c];
    if (child == 0) return {node * 4 + c, kBits - shift, density};
    node = child;
  }
}
inline Cell Locate(const DirectionalNode* nodes, Vec2 square) { return Locate(nodes, ToInteger(square.x), ToInteger(square.y)); }

struct Point {
  Vec2 square;
  float density;  // the cell's; equals Locate(square).density
  bool near_border;  // a direction and back may end in another cell
  Vec2 center;       // of the cell
};

// How far DirectionToCylindrical(CylindricalToDirection(s)) strays from s at most, with a factor of two to spare (tests/guiding).
inline constexpr double kRoundTrip = 5e-7;

// Hierarchical warping: u.x chooses the halves in cos theta, u.y those in phi given the former, so stratified u stay stratified. Both
// are kept as a numerator over a product of probabilities, which costs no division on the way. The numbers carry 24 bits; a hash fills
// the bits below, which a deep descent would otherwise find empty.
inline Point Sample(const DirectionalNode* nodes, Vec2 u) {
  const uint64_t low = Mix64((uint64_t{std::bit_cast<uint32_t>(u.x)} << 32) | std::bit_cast<uint32_t>(u.y));
  double x = std::min(u.x + static_cast<double>(low >> 35) * 0x1p-53, 0x1.fffffffffffffp-1);
  double y = std::min(u.y + static_cast<double>(low & 0x1fffffff) * 0x1p-53, 0x1.fffffffffffffp-1);
  double x_range = 1, y_range = 1;
  float density = kUniformSpherePdf;
  uint32_t node = 0, ix = 0, iy = 0;
  int depth = 0;
  do {
    const DirectionalNode& n = nodes[node];
    const double p0 = n.probability[0], p1 = n.probability[1], p2 = n.probability[2], p3 = n.probability[3];
    const double left = p0 + p2, right = p1 + p3;
    const double x_split = x_range * left;
    // A child of probability zero is never chosen, also where rounding says so.
    const bool bx = (x >= x_split) & (right > 0);
    const double column = bx ? right : left, lower = bx ? p1 : p0, upper = bx ? p3 : p2;
    x -= bx ? x_split : 0;
    x_range *= column;
    const double y_split = y_range * lower;
    y *= column;
    const bool by = (y >= y_split) & (upper > 0);
    y -= by ? y_split : 0;
    y_range *= by ? upper : lower;
    ix = ix * 2 + bx;
    iy = iy * 2 + by;
    const uint32_t c = static_cast<uint32_t>(bx) + 2 * static_cast<uint32_t>(by);
    density *= 4 * n.probability[c];
    node = n.child[c];
    ++depth;
  } while (node != 0);
  const double size = std::bit_cast<double>(static_cast<uint64_t>(1023 - depth) << 52);
  const double fx = std::min(x / x_range, 1.0), fy = std::min(y / y_range, 1.0);
  const double margin = std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy)) * size;
  return {{std::min(static_cast<float>((ix + fx) * size), kOneMinusEpsilon), std::min(static_cast<float>((iy + fy) * size), kOneMinusEpsilon)},
          density,
          !(margin > kRoundTrip),
          {static_cast<float>((ix + 0.5) * size), static_cast<float>((iy + 0.5) * size)}};
}

// Calls add(slot, share) for every cell under a footprint of the size of `cell` around (x, y), share of the footprint's area each. The
// footprint wraps around in phi; at the poles it is moved inside, so the shares always sum to 1.
template <class Add>
void ForFootprint(const DirectionalNode* nodes, uint32_t x, uint32_t y, const Cell& cell, Add&& add);

// The order in which a node's subtrees are laid out: by probability, ties by index. A function of the stored floats alone, so that the
// serial form needs no links.
std::array<int, 4> LikeliestFirst(const DirectionalNode& node);

struct Tree {
  std::vector<DirectionalNode> nodes;
  int depth = 0;
};

// The tree of the next iteration: masses are per slot of `nodes` (inner slots may hold mass of their own: none does today). A cell above
// `flux_threshold` of the total splits, its children a quarter each, recursively; an inner node with no more becomes a cell.
// total > 0, masses finite and not negative.
Tree Rebuild(const DirectionalNode* nodes, uint32_t node_count, std::vector<double> masses, double flux_threshold, int max_depth);

namespace detail {

struct Rectangle {
  uint32_t x0, y0, x1, y1;
};

template <class Add>
void Splat(const DirectionalNode* nodes, uint32_t node, uint32_t node_x, uint32_t node_y, int shift, const Rectangle& r, float scale, Add& add) {
  const uint32_t half = uint32_t{1} << shift;
  const uint32_t mx = node_x + half, my = node_y + half;
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t cx = c & 1 ? mx : node_x, cy = c & 2 ? my : node_y;
    const uint32_t x0 = std::max(cx, r.x0), x1 = std::min(cx + half, r.x1), y0 = std::max(cy, r.y0), y1 = std::min(cy + half, r.y1);
    if (x0 >= x1 || y0 >= y1) continue;
    if (nodes[node].child[c] != 0) {
      Splat(nodes, nodes[node].child[c], cx, cy, shift - 1, r, scale, add);
    } else {
      add(node * 4 + c, static_cast<float>(x1 - x0) * static_cast<float>(y1 - y0) * scale);
    }
  }
}

}  // namespace detail

template <class Add>
void ForFootprint(const DirectionalNode* nodes, uint32_t x, uint32_t y, const Cell& cell, Add&& add) {
  constexpr uint32_t kEnd = uint32_t{1} << kBits;
  const uint32_t size = kEnd >> cell.depth;
  const float scale = 1 / (static_cast<float>(size) * static_cast<float>(size));  // a power of two
  const uint32_t x0 = std::min(x - std::min(x, size / 2), kEnd - size);
  const uint32_t y0 = (y - size / 2) & (kEnd - 1);
  const uint32_t y1 = y0 + size;
  if (y1 <= kEnd) {
    detail::Splat(nodes, 0, 0, 0, kBits - 1, {x0, y0, x0 + size, y1}, scale, add);
  } else {
    detail::Splat(nodes, 0, 0, 0, kBits - 1, {x0, y0, x0 + size, kEnd}, scale, add);
    detail::Splat(nodes, 0, 0, 0, kBits - 1, {x0, 0, x0 + size, y1 - kEnd}, scale, add);
  }
}

}  // namespace directional
}  // namespace lodestar
