// Pictures of what a guide knows about space, as grids of floats (guide_picture.h), looked at along an axis: x with y
// to the right and z up, y with x and z, z with x and y.
#pragma once

#include "core/guiding/focal_field.h"
#include "core/guiding/guide_picture.h"
#include "core/guiding/sd_tree.h"

namespace lodestar {

constexpr int RightAxis(int axis) {
  return axis == 0 ? 1 : 0;
}
constexpr int UpAxis(int axis) {
  return axis == 2 ? 1 : 2;
}

// Which spatial leaf each pixel of a plane lies in.
struct LeafPicture {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> leaves;  // row by row from the top
  uint32_t At(uint32_t x, uint32_t y) const { return leaves[size_t{y} * width + x]; }
  // Another leaf begins to the right or below.
  bool Border(uint32_t x, uint32_t y) const {
    return (x + 1 < width && At(x + 1, y) != At(x, y)) || (y + 1 < height && At(x, y + 1) != At(x, y));
  }
  FloatGrid Of(const std::function<float(uint32_t leaf)>& value) const;
};

// The plane through `p` across the axis, within `window`, which has some extent along both other axes; `longest` pixels
// along the longer of them.
LeafPicture DrawLeaves(const SpatialTree& tree, int axis, Vec3 p, const Bounds3& window, uint32_t longest);

// Densities along lines of sight, relative to the mean of the field's box (Sadek 2025, section 3.8.1). Averages are
// over the part of the line that lies in the box.
enum class Projection : uint8_t { kMaximum, kAverage };

// The whole box of one of the field's octrees seen along an axis: `longest` pixels along the longer side. The mean of
// an average projection over all pixels is the octree's share of the mass.
FloatGrid ProjectFocal(const FocalField& field, size_t octree, int axis, Projection projection, uint32_t longest);

// Along one ray up to `distance`; 0 where it misses the box.
float FocalAlongRay(const FocalField& field, size_t octree, Vec3 origin, Vec3 w, float distance, Projection projection);

}  // namespace lodestar
