// Maps from the unit square to sampling domains. Those of the sphere stand beside their densities, the cylindrical one
// beside its inverse too; the others are uniform.
#pragma once

#include <utility>

#include "core/math/elementary.h"
#include "core/math/vec.h"

namespace lodestar {

// Concentric map (Shirley and Chiu 1997): low distortion, area-preserving up to pi.
inline Vec2 SquareToDisk(Vec2 u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  float r, theta;
  if (std::fabs(a) > std::fabs(b)) {
    r = a;
    theta = (kPi / 4) * (b / a);
  } else {
    r = b;
    theta = kPi / 2 - (kPi / 4) * (a / b);
  }
  const auto [sin, cos] = SinCos(theta);
  return {r * cos, r * sin};
}

inline Vec3 SquareToCosineHemisphere(Vec2 u) {
  const Vec2 d = SquareToDisk(u);
  return {d.x, d.y, SafeSqrt(1 - d.x * d.x - d.y * d.y)};
}
inline float CosineHemispherePdf(float cos_theta) {
  return std::max(cos_theta, 0.0f) * kInvPi;
}

inline Vec3 SquareToSphere(Vec2 u) {
  const float z = 1 - 2 * u.x;
  const float r = SafeSqrt(1 - z * z);
  const auto [sin, cos] = SinCos(2 * kPi * u.y);
  return {r * cos, r * sin, z};
}
inline constexpr float kUniformSpherePdf = kInvPi / 4;

// The cylindrical equal-area square of Mueller et al. 2017: ((cos theta + 1) / 2, phi / 2 pi), both in [0, 1).
inline Vec3 CylindricalToDirection(Vec2 square) {
  const float z = 2 * square.x - 1;
  const float r = SafeSqrt(1 - z * z);
  const auto [sin, cos] = SinCos(2 * kPi * square.y);
  return {r * cos, r * sin, z};
}
inline Vec2 DirectionToCylindrical(Vec3 w) {
  float phi = Atan2(w.y, w.x) * (0.5f * kInvPi);
  if (phi < 0) phi += 1;
  return {std::clamp(w.z * 0.5f + 0.5f, 0.0f, kOneMinusEpsilon), std::clamp(phi, 0.0f, kOneMinusEpsilon)};
}

// Uniform in a triangle: barycentric weights of the first two corners (Heitz 2019, "A Low-Distortion Map Between
// Triangle and Square").
inline Vec2 SquareToTriangle(Vec2 u) {
  if (u.y > u.x) {
    u.x *= 0.5f;
    u.y -= u.x;
  } else {
    u.y *= 0.5f;
    u.x -= u.y;
  }
  return u;
}

}  // namespace lodestar
