// Infinite lights: constant, or an equal-area octahedral image (Clarberg 2008, "Fast Equal-Area Mapping of the
// (Hemi)Sphere using SIMD"), whose texels are constant patches of sky.
//
// Texels of an image are sampled by how much brighter they are than its mean (MIS compensation: Karlik et al. 2019,
// "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling"; brightness here is the
// mean of the channels). The dim rest, which directions drawn for the surface find as well, is theirs alone: its
// density is 0, so light sampling must be combined with them. In living-room that takes 24 to 30 % off the relative
// variance.
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

// Irradiance of an image of size * size pixels on a plane that faces +z.
Rgb IrradianceFromAbove(const std::vector<Rgb>& pixels, int size);

class EnvironmentLight {
 public:
  explicit EnvironmentLight(Rgb constant) : mean_(constant) {}
  // pixels: size * size, row by row.
  EnvironmentLight(const std::vector<Rgb>& pixels, int size, const Transform& world_from_light);

  struct Value {
    Rgb radiance;
    float pdf;  // of Sample producing the direction, per solid angle
  };
  Value Evaluate(Vec3 wi) const;
  Vec3 Sample(Vec2 u, Value* value) const;
  // Mean over the sphere.
  Rgb mean() const { return mean_; }
  size_t memory_bytes() const;

 private:
  // What a lookup needs in one cache line: sampling finds the texel by `end` and has its radiance.
  struct alignas(16) Texel {
    Rgb radiance;
    float end;  // of the distribution function along the row
  };
  using RowCdf = GuidedCdf<sizeof(Texel) / sizeof(float)>;
  Value ValueOf(const Texel& texel) const { return {texel.radiance, Weight(texel.radiance) * density_}; }
  float Weight(Rgb c) const { return std::max(Mean(c) - floor_, 0.0f); }
  static float Mean(Rgb c) { return (c.r + c.g + c.b) * (1 / 3.0f); }

  Rgb mean_;
  uint32_t size_ = 0;  // 0: constant
  float floor_ = 0;    // brightness that sampling leaves to the other technique
  float density_ = 0;  // per solid angle and unit of weight
  LargeVector<Texel> texels_;
  std::vector<float> row_ends_;                      // of the distribution function over rows
  std::vector<uint16_t> row_guide_, column_guides_;  // column_guides_: row by row
  std::array<Vec3, 3> world_from_light_;             // columns, orthonormal
  std::array<Vec3, 3> light_from_world_;
};

}  // namespace lodestar
