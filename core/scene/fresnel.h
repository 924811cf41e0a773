// Fresnel reflectances of unpolarized light and refraction. Cosines are against the (micro)normal on the side of the
// incident direction.
#pragma once

#include <immintrin.h>

#include "core/math/rgb.h"
#include "core/math/vec.h"

namespace lodestar {

struct DielectricFresnel {
  float reflectance;
  float cos_t;  // of the refracted direction, positive; 0 under total internal reflection
};

// cos_i in [0, 1]; eta = index of the far side over that of the near side.
inline DielectricFresnel FresnelDielectric(float cos_i, float eta) {
  const float sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (!(sin2_t < 1)) return {1, 0};
  const float cos_t = std::sqrt(1 - sin2_t);
  // Both polarizations over one denominator: (p1/q1)^2 + (p2/q2)^2 = ((p1 q2)^2 + (p2 q1)^2) / (q1 q2)^2.
  const float p1 = eta * cos_i - cos_t, q1 = eta * cos_i + cos_t;
  const float p2 = cos_i - eta * cos_t, q2 = cos_i + eta * cos_t;
  const float a = p1 * q2, b = p2 * q1, q = q1 * q2;
  if (!(q * q > 0)) return {1, cos_t};
  return {std::min(0.5f * (a * a + b * b) / (q * q), 1.0f), cos_t};
}

// Exact for a complex index eta + ik over vacuum (Born and Wolf, section 13.2), the three channels side by side.
inline Rgb FresnelConductor(float cos_i, Rgb eta, Rgb k) {
  const auto all = [](float v) { return _mm_set1_ps(v); };
  const __m128 e = _mm_setr_ps(eta.r, eta.g, eta.b, 1), kk = _mm_setr_ps(k.r, k.g, k.b, 0);
  const float c = std::clamp(cos_i, 0.0f, 1.0f);
  const __m128 c2 = all(c * c), s2 = all(1 - c * c);
  const __m128 e2 = _mm_mul_ps(e, e), k2 = _mm_mul_ps(kk, kk);
  const __m128 t0 = _mm_sub_ps(_mm_sub_ps(e2, k2), s2);
  const __m128 ab = _mm_sqrt_ps(_mm_add_ps(_mm_mul_ps(t0, t0), _mm_mul_ps(all(4), _mm_mul_ps(e2, k2))));  // a^2 + b^2
  const __m128 a = _mm_sqrt_ps(_mm_max_ps(_mm_mul_ps(all(0.5f), _mm_add_ps(ab, t0)), all(0)));
  const __m128 t1 = _mm_add_ps(ab, c2), t2 = _mm_mul_ps(all(2 * c), a);
  const __m128 t3 = _mm_add_ps(_mm_mul_ps(c2, ab), _mm_mul_ps(s2, s2)), t4 = _mm_mul_ps(t2, s2);
  const __m128 tiny = all(1e-30f);
  const __m128 rs = _mm_div_ps(_mm_sub_ps(t1, t2), _mm_max_ps(_mm_add_ps(t1, t2), tiny));
  const __m128 rp = _mm_mul_ps(rs, _mm_div_ps(_mm_sub_ps(t3, t4), _mm_max_ps(_mm_add_ps(t3, t4), tiny)));
  const __m128 f = _mm_min_ps(_mm_max_ps(_mm_mul_ps(all(0.5f), _mm_add_ps(rs, rp)), all(0)), all(1));
  alignas(16) float out[4];
  _mm_store_ps(out, f);
  return {out[0], out[1], out[2]};
}

// w refracted through the microfacet m, dot(w, m) = cos_i > 0; eta and cos_t as in FresnelDielectric. Unit if w and m
// are.
inline Vec3 Refract(Vec3 w, Vec3 m, float cos_i, float cos_t, float eta) {
  const float inv = 1 / eta;
  return m * (cos_i * inv - cos_t) - w * inv;
}

// w carried across a flat interface and kept on the upper hemisphere: where the light of direction w runs on the other
// side, eta = index of the other side over that of w's. z is 0 under total internal reflection.
inline Vec3 AcrossFlatInterface(Vec3 w, float eta) {
  const float inv = 1 / eta, x = w.x * inv, y = w.y * inv;
  return {x, y, SafeSqrt(1 - x * x - y * y)};
}

}  // namespace lodestar
