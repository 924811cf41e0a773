#include "core/guiding/focal_projection.h"

#include "core/base/check.h"

namespace lodestar {

FocalProjection Project(const FocalField& field, FocalProjection::Kind kind, uint32_t width, uint32_t height,
                        const std::function<FocalPixelRay(uint32_t x, uint32_t y)>& ray) {
  FocalProjection projection{width, height, {}};
  projection.values.reserve(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const FocalPixelRay pixel = ray(x, y);
      const FocalRay walked = field.RayOf(pixel.origin, pixel.direction);
      const float end = pixel.distance / field.longest_side();
      float largest = 0;
      double integral = 0, length = 0;
      for (const FocalOctree& octree : field.octrees()) {
        octree.ForVoxels(walked, end, [&](uint32_t, float t0, float t1, float density) {
          largest = std::max(largest, density);
          integral += double{density} * (t1 - t0);
          length += t1 - t0;
        });
      }
      const bool maximum = kind == FocalProjection::Kind::kMaximum;
      const float density = maximum ? largest : length > 0 ? static_cast<float>(integral / length) : 0;
      projection.values.push_back(field.RelativeDensity(density));
    }
  }
  return projection;
}

FocalProjection ProjectAlong(const FocalField& field, FocalProjection::Kind kind, int axis, uint32_t width) {
  LODESTAR_CHECK(axis >= 0 && axis < 3 && width > 0);
  const int right = (axis + 1) % 3, up = (axis + 2) % 3;
  const float pixel = field.sides()[right] / static_cast<float>(width);
  const auto height = std::max<uint32_t>(1, static_cast<uint32_t>(std::lround(field.sides()[up] / pixel)));
  const float pixel_up = field.sides()[up] / static_cast<float>(height);
  Vec3 direction;
  direction[axis] = 1;
  return Project(field, kind, width, height, [&](uint32_t x, uint32_t y) {
    Vec3 origin = field.corner();
    origin[right] += (static_cast<float>(x) + 0.5f) * pixel;
    origin[up] += (static_cast<float>(height - 1 - y) + 0.5f) * pixel_up;
    return FocalPixelRay{origin, direction};
  });
}

}  // namespace lodestar
