#include "core/guiding/spatial_tree.h"

namespace lodestar {

std::optional<SpatialTree> SpatialTree::FromDepths(Vec3 corner, float size, std::span<const uint8_t> depths) {
  SpatialTree tree;
  tree.corner_ = corner;
  tree.size_ = size;
  tree.scale_ = static_cast<float>(1 << kBits) / size;
  tree.nodes_.emplace_back();
  tree.cells_.reserve(depths.size());
  if (!tree.Fill(0, 0, 0, {}, depths) || tree.cells_.size() != depths.size()) return std::nullopt;
  return tree;
}

// Fills the entries of `node` whose first `level` octant bits are those of `octant` with what lies in `cell`.
bool SpatialTree::Fill(uint32_t node, int level, uint32_t octant, Cell cell, std::span<const uint8_t> depths) {
  if (cells_.size() >= depths.size()) return false;
  const int depth = depths[cells_.size()];
  if (depth < cell.depth || depth > kMaxDepth) return false;
  if (depth == cell.depth) {
    const uint32_t leaf = leaf_count();
    for (uint32_t rest = 0; rest < 8; rest += uint32_t{1} << level) nodes_[node][octant | rest] = leaf | kLeaf;
    cells_.push_back(cell);
    return true;
  }
  if (level == 3) {
    const uint32_t child = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    nodes_[node][octant] = child;
    return Fill(child, 0, 0, cell, depths);
  }
  Cell half = cell;
  ++half.depth;
  if (!Fill(node, level + 1, octant, half, depths)) return false;
  half.lower[level] += half.Size(level);
  return Fill(node, level + 1, octant | (uint32_t{1} << level), half, depths);
}

Bounds3 SpatialTree::LeafBounds(uint32_t leaf) const {
  const Cell& cell = cells_[leaf];
  const float unit = size_ / static_cast<float>(1 << kBits);
  Bounds3 bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.min[axis] = corner_[axis] + static_cast<float>(cell.lower[axis]) * unit;
    bounds.max[axis] = corner_[axis] + static_cast<float>(cell.lower[axis] + cell.Size(axis)) * unit;
  }
  return bounds;
}

}  // namespace lodestar
