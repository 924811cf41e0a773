// Hemispheres over the cells of a sphere: which entries of a radiance grid a surface of a given normal sees where.
//
// A hemisphere is the square (sin^2 theta, phi / 2 pi) about the normal, on which cosine-weighted directions are even:
// a density over it that is proportional to the radiance is, in solid angle, proportional to radiance times cosine, and
// nothing of it lies below the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/elementary.h"
#include "core/math/frame.h"

namespace lodestar {

// The square's point for a direction in a frame; only for w.z > 0.
inline Vec2 DirectionToHemisphere(Vec3 w) {
  float phi = Atan2(w.y, w.x) * (0.5f * kInvPi);
  if (phi < 0) phi += 1;
  return {std::min(w.x * w.x + w.y * w.y, kOneMinusEpsilon), std::clamp(phi, 0.0f, kOneMinusEpsilon)};
}
inline Vec3 HemisphereToDirection(Vec2 square) {
  const float r = std::sqrt(square.x);
  const auto [sin, cos] = SinCos(2 * kPi * square.y);
  return {r * cos, r * sin, std::sqrt(1 - square.x)};
}

class GridHemispheres {
 public:
  // Normals are told apart by the cells of a cube's faces. Their number is odd, so that the axes lie in the middle of
  // cells; no normal is further than 12 degrees from its cell's.
  static constexpr uint32_t kNormalSide = 7, kNormals = 6 * kNormalSide * kNormalSide;
  static uint32_t NormalAt(Vec3 n);
  static Vec3 NormalCenter(uint32_t normal);

  // For grids of `directions` rows, of which a hemisphere has as many rows and columns; made once a process.
  static const GridHemispheres& Of(int directions);

  // The frame of a normal that lies in the cell: a rotation of the cell's own by as little as it takes.
  Frame FrameOf(uint32_t normal, Vec3 n) const { return Frame::FromNormalAndTangent(n, frames_[normal].s); }
  uint32_t rows() const { return rows_; }
  uint32_t columns() const { return rows_; }
  // Mean of the radiances (of the cells of a sphere) over each cell of the hemisphere's square; `out` by row, then
  // column.
  void Gather(uint32_t normal, std::span<const float> radiances, std::span<double> out) const;

 private:
  static constexpr uint32_t kPoints =
      4;  // looked up in each cell of the square, whose solid angle is a cell of the sphere's
  explicit GridHemispheres(int directions);

  uint32_t rows_;
  std::vector<Frame> frames_;
  std::vector<uint16_t> entries_;  // by normal, then cell, then point
};

}  // namespace lodestar
