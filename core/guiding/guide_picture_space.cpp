#include "core/guiding/guide_picture_space.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace lodestar {

Bounds3 PictureWindow(const Bounds3& bounds) {
  const Vec3 sides = bounds.Diagonal();
  const float longest = std::max(MaxComponent(sides), 1e-20f);
  Bounds3 window = bounds;
  for (int axis = 0; axis < 3; ++axis) {
    const float more = 0.02f * longest + std::max(0.0f, 0.125f * longest - sides[axis]) / 2;
    window.min[axis] -= more;
    window.max[axis] += more;
  }
  return window;
}

FloatGrid EmptyPicture(Vec3 sides, int axis, uint32_t longest) {
  const float right = sides[RightAxis(axis)], up = sides[UpAxis(axis)];
  LODESTAR_CHECK(right > 0 && up > 0);
  const auto shorter = [&](float side, float long_side) {
    return std::max(1u, static_cast<uint32_t>(std::lround(static_cast<float>(longest) * (side / long_side))));
  };
  return right >= up ? FloatGrid(longest, shorter(up, right)) : FloatGrid(shorter(right, up), longest);
}

void AddSegment(Vec3 from, Vec3 to, float value, const Bounds3& window, int axis, FloatGrid* grid) {
  const int right = RightAxis(axis), up = UpAxis(axis);
  const Vec3 sides = window.Diagonal();
  const auto pixel = [&](Vec3 p) {
    return Vec2{(p[right] - window.min[right]) / sides[right] * static_cast<float>(grid->width),
                (window.max[up] - p[up]) / sides[up] * static_cast<float>(grid->height)};
  };
  // One pixel a step along the longer direction: none is met twice.
  const Vec2 a = pixel(from), d = pixel(to) - a;
  const float steps = std::ceil(std::max(std::fabs(d.x), std::fabs(d.y)));
  if (!(steps < 1e5f)) return;
  for (float i = 0; i < std::max(steps, 1.0f); ++i) {
    const Vec2 at = a + d * ((i + 0.5f) / std::max(steps, 1.0f));
    if (at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(grid->width) && at.y < static_cast<float>(grid->height))
      grid->At(static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y)) += value;
  }
}

FloatGrid LeafPicture::Of(const std::function<float(uint32_t)>& value) const {
  FloatGrid grid(width, height);
  for (size_t i = 0; i < leaves.size(); ++i) grid.values[i] = value(leaves[i]);
  return grid;
}

LeafPicture DrawLeaves(const SpatialTree& tree, int axis, Vec3 p, const Bounds3& window, uint32_t longest) {
  const int right = RightAxis(axis), up = UpAxis(axis);
  const Vec3 sides = window.Diagonal();
  const FloatGrid size = EmptyPicture(sides, axis, longest);
  LeafPicture picture{size.width, size.height, {}};
  picture.leaves.reserve(size_t{size.width} * size.height);
  for (uint32_t y = 0; y < size.height; ++y) {
    for (uint32_t x = 0; x < size.width; ++x) {
      Vec3 at = p;
      at[right] = window.min[right] + sides[right] * ((static_cast<float>(x) + 0.5f) / static_cast<float>(size.width));
      at[up] = window.max[up] - sides[up] * ((static_cast<float>(y) + 0.5f) / static_cast<float>(size.height));
      picture.leaves.push_back(tree.LeafAt(at));
    }
  }
  return picture;
}

}  // namespace lodestar
