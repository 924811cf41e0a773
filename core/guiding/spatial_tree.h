// The S-tree: binary midpoint splits, axes x, y, z in turn, over the scene's bounds made cubic (Mueller et al. 2017,
// section 3).
//
// It is held collapsed, three binary levels to a node of eight entries, so that a lookup takes a third of the dependent
// loads. Positions become 21-bit integers once; from then on all is integer arithmetic, and a point on a border or
// outside the box (or NaN) has one well-defined leaf. The leaves' depths in depth-first order (lower half first) say
// everything: that list is its serial form.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/huge_pages.h"
#include "core/math/bounds.h"

namespace lodestar {

class SpatialTree {
 public:
  static constexpr int kBits = 21;
  static constexpr int kMaxDepth = 3 * kBits;
  using Coordinates = std::array<uint32_t, 3>;  // each below 2^kBits

  struct Cell {
    Coordinates lower{};
    int depth = 0;
    // Levels that halved an axis: x is first.
    int Levels(int axis) const { return (depth + 2 - axis) / 3; }
    uint32_t Size(int axis) const { return uint32_t{1} << (kBits - Levels(axis)); }
  };

  SpatialTree() = default;
  // The depths must form a full binary tree; nothing when they do not (corrupt bytes).
  static std::optional<SpatialTree> FromDepths(Vec3 corner, float size, std::span<const uint8_t> depths);

  Coordinates ToCoordinates(Vec3 p) const {
    return {ToCoordinate(p.x - corner_.x), ToCoordinate(p.y - corner_.y), ToCoordinate(p.z - corner_.z)};
  }
  uint32_t LeafAt(Vec3 p) const { return LeafAt(ToCoordinates(p)); }
  uint32_t LeafAt(const Coordinates& at) const {
    uint32_t node = 0;
    for (int shift = kBits - 1;; --shift) {
      const uint32_t octant = ((at[0] >> shift) & 1) | (((at[1] >> shift) & 1) << 1) | (((at[2] >> shift) & 1) << 2);
      const uint32_t entry = nodes_[node][octant];
      if (entry & kLeaf) return entry & ~kLeaf;
      node = entry;
    }
  }

  // Calls visit(leaf, share) for every leaf that overlaps the box [lower, lower + size), share of the box's volume
  // each; a leaf can be visited more than once. The box must lie inside the tree.
  template <class Visit>
  void ForOverlaps(const Coordinates& lower, const Coordinates& size, Visit&& visit) const {
    const double scale = 1 / (static_cast<double>(size[0]) * size[1] * size[2]);
    Overlap(0, {0, 0, 0}, kBits - 1, lower, size, scale, visit);
  }

  uint32_t leaf_count() const { return static_cast<uint32_t>(cells_.size()); }
  const Cell& cell(uint32_t leaf) const { return cells_[leaf]; }
  Bounds3 LeafBounds(uint32_t leaf) const;
  Vec3 corner() const { return corner_; }
  float size() const { return size_; }
  size_t memory() const { return nodes_.size() * sizeof(nodes_[0]) + cells_.size() * sizeof(Cell); }

 private:
  static constexpr uint32_t kLeaf = 0x80000000u;

  uint32_t ToCoordinate(float offset) const {
    // max first: it turns NaN into 0.
    return static_cast<uint32_t>(std::min(std::max(0.0f, offset * scale_), static_cast<float>((1 << kBits) - 1)));
  }

  template <class Visit>
  void Overlap(uint32_t node, const Coordinates& origin, int shift, const Coordinates& lower, const Coordinates& size,
               double scale, Visit& visit) const {
    const uint32_t half = uint32_t{1} << shift;
    for (uint32_t octant = 0; octant < 8; ++octant) {
      Coordinates corner;
      double volume = scale;
      for (int axis = 0; axis < 3; ++axis) {
        corner[axis] = origin[axis] + (((octant >> axis) & 1) ? half : 0);
        const uint32_t from = std::max(corner[axis], lower[axis]),
                       to = std::min(corner[axis] + half, lower[axis] + size[axis]);
        volume *= to > from ? to - from : 0;
      }
      if (volume <= 0) continue;
      const uint32_t entry = nodes_[node][octant];
      if (entry & kLeaf) {
        visit(entry & ~kLeaf, volume);
      } else {
        Overlap(entry, corner, shift - 1, lower, size, scale, visit);
      }
    }
  }
  bool Fill(uint32_t node, int level, uint32_t octant, Cell cell, std::span<const uint8_t> depths);

  Vec3 corner_;
  float size_ = 1;
  float scale_ = 1;                             // 2^kBits / size
  LargeVector<std::array<uint32_t, 8>> nodes_;  // a node lies in one cache line
  std::vector<Cell> cells_;
};

}  // namespace lodestar
