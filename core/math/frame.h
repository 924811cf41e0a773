// Orthonormal shading frames; in local coordinates the normal is +z.
#pragma once

#include "core/math/vec.h"

namespace lodestar {

struct Frame {
  Vec3 s{1, 0, 0}, t{0, 1, 0}, n{0, 0, 1};

  // Duff et al. 2017, "Building an Orthonormal Basis, Revisited": no branch, no singular direction.
  static Frame FromNormal(Vec3 n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
  // s along the part of `tangent` perpendicular to n; any frame where there is none.
  static Frame FromNormalAndTangent(Vec3 n, Vec3 tangent) {
    const Vec3 s = tangent - n * Dot(n, tangent);
    const float length_squared = LengthSquared(s);
    if (!(length_squared > 1e-12f * LengthSquared(tangent)) || !std::isfinite(length_squared)) return FromNormal(n);
    const Vec3 unit = s * (1 / std::sqrt(length_squared));
    return {unit, Cross(n, unit), n};
  }
  Vec3 ToLocal(Vec3 v) const { return {Dot(v, s), Dot(v, t), Dot(v, n)}; }
  Vec3 ToWorld(Vec3 v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace lodestar
