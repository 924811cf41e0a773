// The GGX (Trowbridge-Reitz) microfacet distribution with Smith's height-correlated masking, anisotropic. Local frame,
// normal +z; every direction here has z > 0 unless said otherwise.
//
// Masking is written through a(w) = |(ax wx, ay wy, wz)|: Lambda(w) = (a(w)/|wz| - 1)/2, so that G2 / (4 co ci) and the
// density of visible normals need no division by a cosine and hold at grazing angles (Heitz 2014, "Understanding the
// Masking-Shadowing Function", eq. 72, 86, 99).
#pragma once

#include <algorithm>

#include "core/math/elementary.h"
#include "core/math/vec.h"

namespace lodestar {

struct Ggx {
  Vec2 alpha;

  // pbrt-v4's rule: a distribution whose larger alpha is below the limit is a mirror; a small one beside a larger is
  // kept above 1e-4.
  static bool IsSmooth(Vec2 alpha, float limit) { return !(std::max(alpha.x, alpha.y) >= limit); }
  static Ggx Clamped(Vec2 alpha) { return {{std::max(alpha.x, 1e-4f), std::max(alpha.y, 1e-4f)}}; }
  // Of the isotropic distribution that stands in for this one in tables.
  float MeanAlpha() const { return alpha.x == alpha.y ? alpha.x : std::sqrt(alpha.x * alpha.y); }

  // D(m) of the normalized m; m itself may have any length.
  float Density(Vec3 m) const {
    const float xx = m.x * m.x, yy = m.y * m.y, zz = m.z * m.z;
    const float length4 = Sqr(xx + yy + zz);
    if (alpha.x == alpha.y) {
      const float a2 = alpha.x * alpha.x;
      return a2 * length4 * kInvPi / Sqr(xx + yy + a2 * zz);
    }
    const float ax2 = alpha.x * alpha.x, ay2 = alpha.y * alpha.y, axy = alpha.x * alpha.y;
    return axy * axy * axy * length4 * kInvPi / Sqr(xx * ay2 + yy * ax2 + zz * ax2 * ay2);
  }
  float Stretch(Vec3 w) const {  // a(w)
    if (alpha.x == alpha.y) return std::sqrt(alpha.x * alpha.x * (w.x * w.x + w.y * w.y) + w.z * w.z);
    return std::sqrt(Sqr(alpha.x * w.x) + Sqr(alpha.y * w.y) + w.z * w.z);
  }

  // A normal visible from wo, with density 2 |wo.m| D(m) / (a(wo) + bound wo.z): the spherical caps of Dupuy and
  // Benyoub 2023, section 4. bound: 1 for all of them.
  Vec3 SampleVisible(Vec3 wo, Vec2 u, float bound = 1) const {
    const Vec3 stretched = Normalize(Vec3{alpha.x * wo.x, alpha.y * wo.y, wo.z});
    const auto [sin, cos] = SinCos(2 * kPi * u.x);
    const float z = (1 - u.y) * (1 + bound * stretched.z) - bound * stretched.z;
    const float r = SafeSqrt((1 - z) * (1 + z));
    const Vec3 h{alpha.x * (r * cos + stretched.x), alpha.y * (r * sin + stretched.y), std::max(z + stretched.z, 0.0f)};
    const float length2 = LengthSquared(h);
    return length2 > 0 ? h * (1 / std::sqrt(length2)) : Vec3{0, 0, 1};
  }
  // The bound for what reflects wo above the surface: a smaller cap, which still has all those normals and fewer of the
  // others (Eto and Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections", section 3).
  float ReflectionBound(Vec3 wo) const {
    const float a2 = Sqr(std::min({alpha.x, alpha.y, 1.0f})), s2 = Sqr(1 + std::sqrt(wo.x * wo.x + wo.y * wo.y));
    return (1 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
  }
  // wo mirrored by a normal so bounded. What would end below the surface is folded up, by the sign of its z: with the
  // density of both in the denominator (EvaluateReflection), that is a sample more and less variance.
  Vec3 SampleReflection(Vec3 wo, Vec2 u) const {
    const Vec3 m = SampleVisible(wo, u, ReflectionBound(wo));
    const Vec3 wi = m * (2 * Dot(wo, m)) - wo;
    return {wi.x, wi.y, std::fabs(wi.z)};
  }
};

// The half-vector terms of a reflection, shared by value and density.
struct GgxReflection {
  float value;  // D G2 / (4 co ci) * ci
  float pdf;    // of wi
  float cos;    // wo.m
};
// pdf: of wo mirrored by SampleVisible's normal, which may also end below the surface; with the D of a second normal
// that leads to wi, of both. wo.z, wi.z > 0.
inline GgxReflection EvaluateMirrored(const Ggx& ggx, Vec3 wo, Vec3 wi, float bound = 1, float second = 0) {
  const Vec3 m = wo + wi;
  const float d = ggx.Density(m);
  const float ao = ggx.Stretch(wo), ai = ggx.Stretch(wi);
  return {0.5f * d * wi.z / (ao * wi.z + ai * wo.z), 0.5f * (d + second) / (ao + bound * wo.z),
          Dot(wo, m) / std::sqrt(LengthSquared(m))};
}
// pdf: of SampleReflection. What was folded onto wi came from a normal above the surface and within the cap: in the
// stretched frame, in which that normal mirrors wo too, above -bound times the height of wo. Without a branch: whether
// there is such a normal is hard to predict.
inline GgxReflection EvaluateReflection(const Ggx& ggx, Vec3 wo, Vec3 wi) {
  const float bound = ggx.ReflectionBound(wo), axy = ggx.alpha.x * ggx.alpha.y;
  const Vec3 m{wo.x + wi.x, wo.y + wi.y, wo.z - wi.z};
  const float stretched2 = Sqr(m.x * ggx.alpha.y) + Sqr(m.y * ggx.alpha.x) + Sqr(m.z * axy);  // times axy^2
  const float length2 = LengthSquared(m);                                                     // 2 wo.m
  const bool sampled = (m.z > 0) & (length2 * m.z * axy * axy > (1 - bound) * wo.z * stretched2);
  const float d = axy * Sqr(axy * length2 / stretched2) * kInvPi;
  return EvaluateMirrored(ggx, wo, wi, bound, sampled ? d : 0);
}

// G2(wo, wi) / G1(wo), what a reflected or refracted sample weighs beside Fresnel, its normal sampled by SampleVisible;
// cosines positive.
inline float MaskingWeight(float ao, float co, float ai, float ci) {
  return ci * (ao + co) / (ao * ci + ai * co);
}

// Deterministic quadrature over the visible normals of an isotropic distribution seen from the plane y = 0, for tables:
// node n of phis * caps, phi over half the circle (the rest is symmetric). 1 - u.y = w^2 resolves the tail of the
// slopes (w is proportional to the inverse slope at normal incidence), and the caps of neighbouring phis are staggered,
// so that an edge along phi costs 1 / (phis * caps), not 1 / caps.
struct VisibleNormalNode {
  Vec2 u;        // for Ggx::SampleVisible
  float weight;  // the weights add up to 1
};
inline VisibleNormalNode VisibleNormalQuadrature(int n, int phis, int caps) {
  const int i = n % phis, j = n / phis;
  const float stagger = (static_cast<float>(i * 3 % phis) + 0.5f) / static_cast<float>(phis);
  const float w = (static_cast<float>(j) + stagger) / static_cast<float>(caps);
  return {{(static_cast<float>(i) + 0.5f) / static_cast<float>(2 * phis), 1 - w * w},
          2 * w / static_cast<float>(phis * caps)};
}

}  // namespace lodestar
