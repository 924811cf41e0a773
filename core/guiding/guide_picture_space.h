// Planes through a spatial tree as pictures, and how all pictures along an axis lie: x has y to the right and z up, y
// has x and z, z has x and y.
#pragma once

#include "core/guiding/guide_picture.h"
#include "core/guiding/spatial_tree.h"

namespace lodestar {

constexpr int RightAxis(int axis) {
  return axis == 0 ? 1 : 0;
}
constexpr int UpAxis(int axis) {
  return axis == 2 ? 1 : 2;
}

// A box to look at a scene in: a little larger, and with some extent along every axis.
Bounds3 PictureWindow(const Bounds3& bounds);

// Zeros for a view of a box along an axis: `longest` pixels along the longer of its two sides, which are above zero.
FloatGrid EmptyPicture(Vec3 sides, int axis, uint32_t longest);

// Adds the value to every pixel of such a view that the segment passes; `window` is the box.
void AddSegment(Vec3 from, Vec3 to, float value, const Bounds3& window, int axis, FloatGrid* grid);

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

}  // namespace lodestar
