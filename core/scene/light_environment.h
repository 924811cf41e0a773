// Infinite lights: constant, or an equal-area octahedral image (Clarberg 2008, "Fast Equal-Area Mapping of the
// (Hemi)Sphere using SIMD"), whose texels are constant patches of sky, so that sampling a texel by its brightness is
// exactly proportional to radiance.
#pragma once

#include <array>
#include <vector>

#include "core/base/huge_pages.h"
#include "core/math/distribution.h"
#include "core/math/rgb.h"
#include "core/math/transform.h"

namespace lodestar {

// Unit square to unit sphere and back; +z is the middle of the square, area is preserved up to 4 pi.
Vec3 OctahedralToDirection(Vec2 square);
Vec2 DirectionToOctahedral(Vec3 w);

class EnvironmentLight {
 public:
  explicit EnvironmentLight(Rgb constant) : mean_(constant) {}
  // pixels: size * size, row by row.
  EnvironmentLight(const std::vector<Rgb>& pixels, int size, const Transform& world_from_light);

  struct alignas(16) Value {  // one cache line holds all of a texel
    Rgb radiance;
    float pdf;  // per solid angle
  };
  Value Evaluate(Vec3 wi) const;
  Vec3 Sample(Vec2 u, Value* value) const;
  // Mean over the sphere.
  Rgb mean() const { return mean_; }
  size_t memory_bytes() const { return texels_.size() * sizeof(Value) + distribution_.memory_bytes(); }

 private:
  Rgb mean_;
  int size_ = 0;  // 0: constant
  LargeVector<Value> texels_;
  PiecewiseConstant2D distribution_;
  std::array<Vec3, 3> world_from_light_;  // columns, orthonormal
  std::array<Vec3, 3> light_from_world_;
};

}  // namespace lodestar
