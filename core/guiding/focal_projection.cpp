#include "core/guiding/focal_projection.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/guiding/guide_picture_space.h"

namespace lodestar {
namespace {

float RelativeScale(const FocalField& field) {
  return field.mass() > 0 ? static_cast<float>(1 / field.mass()) : 0;
}

// Paints leaf voxels onto a picture along an axis.
class VoxelPainter {
 public:
  VoxelPainter(const FocalOctree& octree, FocalProjection projection, int axis, float scale, FloatGrid* grid)
      : octree_(octree), projection_(projection), axis_(axis), scale_(scale), grid_(grid) {}

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
    const float x0 = corner[RightAxis(axis_)] * w, x1 = x0 + size * w;
    const float y1 = h - corner[UpAxis(axis_)] * h, y0 = y1 - size * h;
    const auto end = [](float to, uint32_t limit) { return std::min(limit, static_cast<uint32_t>(std::ceil(to))); };
    for (uint32_t y = static_cast<uint32_t>(std::max(y0, 0.0f)); y < end(y1, grid_->height); ++y) {
      const float fy = static_cast<float>(y), rows = std::min(fy + 1, y1) - std::max(fy, y0);
      for (uint32_t x = static_cast<uint32_t>(x0); x < end(x1, grid_->width); ++x) {
        const float fx = static_cast<float>(x), covered = rows * (std::min(fx + 1, x1) - std::max(fx, x0));
        if (!(covered > 0)) continue;
        float& value = grid_->At(x, y);
        if (projection_ == FocalProjection::kMaximum) {
          value = std::max(value, density);
        } else {
          value += density * size * covered;
        }
      }
    }
  }

  const FocalOctree& octree_;
  FocalProjection projection_;
  int axis_;
  float scale_;
  FloatGrid* grid_;
};

}  // namespace

FloatGrid Project(const FocalField& field, size_t octree, FocalProjection projection, uint32_t width, uint32_t height,
                  const std::function<FocalPixelRay(uint32_t x, uint32_t y)>& ray) {
  FloatGrid grid(width, height);
  const float scale = RelativeScale(field);
  ParallelFor(height, [&](uint32_t y) {
    for (uint32_t x = 0; x < width; ++x) {
      const FocalPixelRay pixel = ray(x, y);
      float greatest = 0;
      double integral = 0, length = 0;
      field.octrees()[octree].ForVoxels(field.RayOf(pixel.origin, pixel.direction),
                                        pixel.distance / field.longest_side(),
                                        [&](uint32_t, float t0, float t1, float density) {
                                          greatest = std::max(greatest, density);
                                          integral += double{density} * (t1 - t0);
                                          length += t1 - t0;
                                        });
      const float average = length > 0 ? static_cast<float>(integral / length) : 0;
      grid.At(x, y) = (projection == FocalProjection::kMaximum ? greatest : average) * scale;
    }
  });
  return grid;
}

FloatGrid ProjectAlong(const FocalField& field, size_t octree, FocalProjection projection, int axis, uint32_t longest) {
  FloatGrid grid = EmptyPicture(field.sides(), axis, longest);
  VoxelPainter(field.octrees()[octree], projection, axis, RelativeScale(field), &grid).Walk(0, {}, 1);
  return grid;
}

}  // namespace lodestar
