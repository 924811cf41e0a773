// Linearly transformed cosines (Heitz et al. 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed
// Cosines"): a cosine lobe whose directions went through a matrix M. Its integral over a polygon is that of the cosine
// over the polygon that M^-1 makes of it. Here one stands for the GGX reflection lobe times the cosine, without
// Fresnel, as fitted by bench/ltc_fit.cpp.
//
// M = R U: U is upper triangular, with widths x and y and a skew from z to x; R tilts from the normal towards the
// mirror direction. Every isotropic M has this form up to scale, and its inverse needs no determinant to be divided by.
// In place of the tilt, tables have the direction M z, the peak of narrow lobes: they must hit it between entries too.
#pragma once

#include "core/math/elementary.h"
#include "core/math/frame.h"

namespace lodestar {

struct LtcShape {
  float x = 1, y = 1;  // widths, > 0; 1 is the cosine's own
  float skew = 0;      // along x
  float peak_sin = 0;  // of the angle from the normal to M z, positive in the mirror direction's half plane
};

// Shapes over (alpha, angle of wo), bilinear. Axes: sqrt(alpha), and sqrt(1 - cos theta).
class LtcTable {
 public:
  static constexpr int kAlphas = 24, kAngles = 24;
  // The table ends where the lobes are too narrow for any tree and where the fit fails (Diolatzis et al. 2020, section
  // 3.2.3); beyond, its borders are used.
  static constexpr float kMinAlpha = 0.02f, kMinCos = 0.0871557f;  // 85 degrees

  static float Alpha(int row) { return Sqr(Lerp(static_cast<float>(row) / (kAlphas - 1), 0.1414214f, 1.0f)); }
  static float CosAt(int column) { return 1 - Sqr(static_cast<float>(column) / (kAngles - 1)) * (1 - kMinCos); }

  static LtcShape GgxReflection(float alpha, float cos_o);
};

// A shape in a frame: n the normal, s in the plane of wo and n, on the mirror direction's side.
class Ltc {
 public:
  Ltc() = default;
  Ltc(const LtcShape& shape, const Frame& frame) {
    const float peak_cos = SafeSqrt(1 - Sqr(shape.peak_sin)), scale = 1 / std::sqrt(1 + Sqr(shape.skew));
    const float sin = (shape.peak_sin - shape.skew * peak_cos) * scale,
                cos = (peak_cos + shape.skew * shape.peak_sin) * scale;
    const Vec3 x = frame.s * cos - frame.n * sin;
    z_ = frame.s * sin + frame.n * cos;
    x_ = (x - z_ * shape.skew) * (1 / shape.x);
    y_ = frame.t * (1 / shape.y);
    determinant_ = 1 / (shape.x * shape.y);
    width_ = 1 / std::sqrt(std::max(LengthSquared(x_), LengthSquared(y_)));
  }

  // M^-1 w.
  Vec3 ToCosine(Vec3 w) const { return {Dot(x_, w), Dot(y_, w), Dot(z_, w)}; }
  // Per steradian; integrates to 1 over the sphere, zero behind the lobe's own plane.
  float Density(Vec3 w) const {
    const Vec3 p = ToCosine(w);
    return p.z > 0 ? p.z * determinant_ * kInvPi / Sqr(LengthSquared(p)) : 0;
  }
  // The lobe's share in the half space of directions w with n.w > 0, |n| > 0: M maps half spaces to half spaces.
  float ShareAbove(Vec3 n) const {
    const Vec3 m{Dot(n, Cross(y_, z_)), Dot(n, Cross(z_, x_)), Dot(n, Cross(x_, y_))};
    return 0.5f + 0.5f * m.z / Length(m);
  }
  // Of the lobe's narrower direction, in radians where it is small; 1 for the cosine.
  float width() const { return width_; }
  // Of M^-1.
  float determinant() const { return determinant_; }
  // The rows of M^-1.
  Vec3 x() const { return x_; }
  Vec3 y() const { return y_; }
  Vec3 z() const { return z_; }

 private:
  Vec3 x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1};
  float determinant_ = 1, width_ = 1;
};

}  // namespace lodestar
