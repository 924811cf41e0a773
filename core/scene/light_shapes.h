// Sampling directions towards simple emitters: each sampler beside its density per solid angle at the reference point.
#pragma once

#include <optional>

#include "core/math/elementary.h"
#include "core/math/frame.h"
#include "core/math/warp.h"

namespace lodestar {

struct DirectionSample {
  Vec3 wi;
  Vec3 point;  // on the emitter
  float pdf;
};

// ---- triangle ----

struct LightTriangle {
  Vec3 p0, e1, e2;
  Vec3 n;  // unit
  float area;
};

// A triangle seen from a point: unit directions to its corners, and its solid angle (Van Oosterom and Strackee 1983,
// eq. 8).
struct SphericalTriangle {
  Vec3 a, b, c;
  float volume;  // a . (b x c)
  float omega;
};

// By area where the triangle looks small from p, uniformly over its solid angle (Arvo 1995) where it looms large: there
// area sampling has a density that varies by orders of magnitude. False: by area.
inline bool LightTriangleLooms(const LightTriangle& t, Vec3 p, SphericalTriangle* s) {
  constexpr float kLooming = 0.03f, kSmallest = 3e-3f,
                  kLargest = 6.2f;  // outside these Arvo's angles lose their digits
  const Vec3 to_center = t.p0 + (t.e1 + t.e2) * (1 / 3.0f) - p;
  if (!(t.area > kLooming * LengthSquared(to_center))) return false;
  const Vec3 a = t.p0 - p, b = a + t.e1, c = a + t.e2;
  const float la = LengthSquared(a), lb = LengthSquared(b), lc = LengthSquared(c);
  if (!(la > 0 && lb > 0 && lc > 0)) return false;
  s->a = a * (1 / std::sqrt(la));
  s->b = b * (1 / std::sqrt(lb));
  s->c = c * (1 / std::sqrt(lc));
  s->volume = Dot(s->a, Cross(s->b, s->c));
  s->omega = 2 * Atan2(std::fabs(s->volume), 1 + Dot(s->a, s->b) + Dot(s->b, s->c) + Dot(s->c, s->a));
  return s->omega > kSmallest && s->omega < kLargest;
}

// Density per solid angle at p of the point at `offset` = point - p.
inline float LightTrianglePdf(const LightTriangle& t, Vec3 p, Vec3 offset) {
  SphericalTriangle s;
  if (LightTriangleLooms(t, p, &s)) return 1 / s.omega;
  const float d2 = LengthSquared(offset);
  return d2 * std::sqrt(d2) / (AbsDot(t.n, offset) * t.area);
}

inline std::optional<DirectionSample> SampleSphericalTriangle(const LightTriangle& t, const SphericalTriangle& triangle,
                                                              Vec3 p, Vec2 u) {
  const Vec3 a = triangle.a, b = triangle.b, c = triangle.c;
  const Vec3 n_ab = Cross(a, b), n_ca = Cross(c, a);
  const float scale2 = LengthSquared(n_ab) * LengthSquared(n_ca);
  if (!(scale2 > 0)) return {};
  // The angle at a: (a x b) x (c x a) = a (a . (b x c)) up to its sign.
  const float inverse_scale = 1 / std::sqrt(scale2);
  const float cos_alpha = std::clamp(-Dot(n_ab, n_ca) * inverse_scale, -1.0f, 1.0f);
  const float sin_alpha = std::fabs(triangle.volume) * inverse_scale;
  // Sine and cosine of (area to the left of the sample's arc - that angle).
  const auto [sin_area, cos_area] = SinCos(u.x * triangle.omega);
  const float s = sin_area * cos_alpha - cos_area * sin_alpha, k = cos_area * cos_alpha + sin_area * sin_alpha;
  const float v1 = k - cos_alpha, v2 = s + sin_alpha * Dot(a, b);
  const float denominator = (v2 * s + v1 * k) * sin_alpha;
  const float q = std::clamp(denominator != 0 ? ((v2 * k - v1 * s) * cos_alpha - v2) / denominator : 1.0f, -1.0f, 1.0f);
  const auto perpendicular = [](Vec3 v, Vec3 axis) {
    const Vec3 w = v - axis * Dot(v, axis);
    const float l2 = LengthSquared(w);
    return l2 > 0 ? w * (1 / std::sqrt(l2)) : Vec3{};
  };
  // c' on the arc from a to c cuts off the area; then uniform in height along the arc from b to c'.
  const Vec3 cut = a * q + perpendicular(c, a) * SafeSqrt(1 - q * q);
  const float one_minus_z = u.y * 0.5f * LengthSquared(cut - b);
  const Vec3 wi = Normalize(b * (1 - one_minus_z) + perpendicular(cut, b) * SafeSqrt(one_minus_z * (2 - one_minus_z)));
  const float cosine = Dot(t.n, wi);
  const float distance = Dot(t.n, t.p0 - p) / cosine;
  if (!(distance > 0) || !std::isfinite(distance)) return {};
  return DirectionSample{wi, p + wi * distance, 1 / triangle.omega};
}

inline std::optional<DirectionSample> SampleLightTriangle(const LightTriangle& t, Vec3 p, Vec2 u) {
  SphericalTriangle triangle;
  if (LightTriangleLooms(t, p, &triangle)) return SampleSphericalTriangle(t, triangle, p, u);
  const Vec2 b = SquareToTriangle(u);
  const Vec3 point = t.p0 + t.e1 * b.x + t.e2 * b.y, offset = point - p;
  const float d2 = LengthSquared(offset), d = std::sqrt(d2), cos_d = AbsDot(t.n, offset);
  if (!(cos_d > 0)) return {};
  return DirectionSample{offset / d, point, d2 * d / (cos_d * t.area)};
}

// ---- sphere ----

// 1 - cos of the half angle of a sphere's cone, without cancellation; negative where p is inside (or on) it.
inline float SphereCone(Vec3 center, float radius, Vec3 p) {
  const float d2 = LengthSquared(center - p), r2 = radius * radius;
  if (!(d2 > r2 * 1.0001f)) return -1;
  const float sin2 = r2 / d2;
  return sin2 / (1 + std::sqrt(1 - sin2));
}

// Density of the point at `offset` on a sphere with unit outward normal n there.
inline float LightSpherePdf(Vec3 center, float radius, Vec3 p, Vec3 offset, Vec3 n) {
  const float cone = SphereCone(center, radius, p);
  if (cone > 0) return 1 / (2 * kPi * cone);
  const float d2 = LengthSquared(offset);
  return d2 * std::sqrt(d2) / (AbsDot(n, offset) * 4 * kPi * radius * radius);
}

// `n`: outward normal at the sample.
inline std::optional<DirectionSample> SampleLightSphere(Vec3 center, float radius, Vec3 p, Vec2 u, Vec3* n) {
  const float cone = SphereCone(center, radius, p);
  if (!(cone > 0)) {
    *n = SquareToSphere(u);
    const Vec3 point = center + *n * radius, offset = point - p;
    const float d2 = LengthSquared(offset), d = std::sqrt(d2), cos_d = AbsDot(*n, offset);
    if (!(cos_d > 0)) return {};
    return DirectionSample{offset / d, point, d2 * d / (cos_d * 4 * kPi * radius * radius)};
  }
  const Vec3 to_center = center - p;
  const float d2 = LengthSquared(to_center), sin2_max = radius * radius / d2;
  const float one_minus_cos = u.x * cone, cos = 1 - one_minus_cos, sin2 = one_minus_cos * (2 - one_minus_cos);
  const auto [sin_phi, cos_phi] = SinCos(2 * kPi * u.y);
  const Frame frame = Frame::FromNormal(to_center * (1 / std::sqrt(d2)));
  const float sin = std::sqrt(sin2);
  const Vec3 wi = frame.ToWorld({sin * cos_phi, sin * sin_phi, cos});
  // The angle at the centre between the way back to p and the point that wi meets first.
  const float cos_a = sin2 / std::sqrt(sin2_max) + cos * SafeSqrt(1 - sin2 / sin2_max);
  const float sin_a = SafeSqrt(1 - cos_a * cos_a);
  *n = frame.ToWorld({sin_a * cos_phi, sin_a * sin_phi, -cos_a});
  return DirectionSample{wi, center + *n * radius, 1 / (2 * kPi * cone)};
}

}  // namespace lodestar
