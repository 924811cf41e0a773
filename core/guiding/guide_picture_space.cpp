#include "core/guiding/guide_picture_space.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace lodestar {
namespace {

struct PictureSize {
  uint32_t width, height;
};
PictureSize SizeOf(float right, float up, uint32_t longest) {
  LODESTAR_CHECK(right > 0 && up > 0);
  const auto shorter = [&](float side, float long_side) {
    return std::max(1u, static_cast<uint32_t>(std::lround(static_cast<float>(longest) * (side / long_side))));
  };
  return right >= up ? PictureSize{longest, shorter(up, right)} : PictureSize{shorter(right, up), longest};
}

// Projects leaf voxels onto a picture along an axis.
class VoxelPainter {
 public:
  VoxelPainter(const FocalOctree& octree, int axis, Projection projection, float scale, FloatGrid* grid)
      : octree_(octree), axis_(axis), projection_(projection), scale_(scale), grid_(grid) {}

  void Walk(uint32_t index, Vec3 corner, float size) {
    const FocalOctree::Node& node = octree_.node(index);
    const float half = 0.5f * size;
    for (int c = 0; c < 8; ++c) {
      const Vec3 at = corner + Vec3{c & 1 ? half : 0, c & 2 ? half : 0, c & 4 ? half : 0};
      if (node.inner & (1u << c)) {
        Walk(node.Child(c), at, half);
      } else {
        Paint(at, half, node.density[static_cast<size_t>(c)] * scale_);
      }
    }
  }

 private:
  void Paint(Vec3 corner, float size, float density) {
    if (!(density > 0)) return;
    const float w = static_cast<float>(grid_->width), h = static_cast<float>(grid_->height);
    const float x0 = corner[RightAxis(axis_)] * w, x1 = x0 + size * w, y1 = h - corner[UpAxis(axis_)] * h,
                y0 = y1 - size * h;
    const auto end = [](float to, uint32_t limit) { return std::min(limit, static_cast<uint32_t>(std::ceil(to))); };
    for (uint32_t y = static_cast<uint32_t>(std::max(y0, 0.0f)); y < end(y1, grid_->height); ++y) {
      const float fy = static_cast<float>(y), rows = std::min(fy + 1, y1) - std::max(fy, y0);
      for (uint32_t x = static_cast<uint32_t>(x0); x < end(x1, grid_->width); ++x) {
        const float fx = static_cast<float>(x), covered = rows * (std::min(fx + 1, x1) - std::max(fx, x0));
        if (!(covered > 0)) continue;
        float& value = grid_->At(x, y);
        if (projection_ == Projection::kMaximum) {
          value = std::max(value, density);
        } else {
          value += density * size * covered;
        }
      }
    }
  }

  const FocalOctree& octree_;
  int axis_;
  Projection projection_;
  float scale_;
  FloatGrid* grid_;
};

float RelativeScale(const FocalField& field) {
  return field.mass() > 0 ? static_cast<float>(1 / field.mass()) : 0;
}

}  // namespace

FloatGrid LeafPicture::Of(const std::function<float(uint32_t)>& value) const {
  FloatGrid grid(width, height);
  for (size_t i = 0; i < leaves.size(); ++i) grid.values[i] = value(leaves[i]);
  return grid;
}

LeafPicture DrawLeaves(const SpatialTree& tree, int axis, Vec3 p, const Bounds3& window, uint32_t longest) {
  const int right = RightAxis(axis), up = UpAxis(axis);
  const Vec3 sides = window.Diagonal();
  const PictureSize size = SizeOf(sides[right], sides[up], longest);
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

FloatGrid ProjectFocal(const FocalField& field, size_t octree, int axis, Projection projection, uint32_t longest) {
  const PictureSize size = SizeOf(field.sides()[RightAxis(axis)], field.sides()[UpAxis(axis)], longest);
  FloatGrid grid(size.width, size.height);
  VoxelPainter(field.octrees()[octree], axis, projection, RelativeScale(field), &grid).Walk(0, {}, 1);
  return grid;
}

float FocalAlongRay(const FocalField& field, size_t octree, Vec3 origin, Vec3 w, float distance,
                    Projection projection) {
  float greatest = 0, sum = 0, length = 0;
  field.octrees()[octree].ForVoxels(field.RayOf(origin, w), distance / field.longest_side(),
                                    [&](uint32_t, float t0, float t1, float density) {
                                      greatest = std::max(greatest, density);
                                      sum += density * (t1 - t0);
                                      length += t1 - t0;
                                    });
  const float value = projection == Projection::kMaximum ? greatest : length > 0 ? sum / length : 0;
  return value * RelativeScale(field);
}

}  // namespace lodestar
