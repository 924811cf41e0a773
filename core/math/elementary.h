// Elementary functions whose results do not depend on the machine: libm picks a variant by CPU at run time, which would
// break the bit-identity of images between workers. Only +, -, *, /, sqrt and explicit fma are used. Polynomials are
// the single-precision minimax approximations of Cephes (Moshier 1992). Measured errors are in
// tests/math/elementary_test.cpp.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/math/vec.h"

namespace lodestar {

struct SinCosResult {
  float sin, cos;
};

// |x| <= 8192; absolute error below 2e-7.
inline SinCosResult SinCos(float x) {
  const float ax = std::fabs(x);
  const int32_t octant = static_cast<int32_t>(ax * (4 / kPi));
  const int32_t j = (octant + 1) & ~1;
  const float y = static_cast<float>(j);
  // Cody-Waite reduction by pi/4 in three parts.
  float z = ((ax - y * 0.78515625f) - y * 2.4187564849853515625e-4f) - y * 3.77489497744594108e-8f;
  const float zz = z * z;
  const float c =
      ((2.443315711809948e-5f * zz - 1.388731625493765e-3f) * zz + 4.166664568298827e-2f) * zz * zz - 0.5f * zz + 1;
  const float s = ((-1.9515295891e-4f * zz + 8.3321608736e-3f) * zz - 1.6666654611e-1f) * zz * z + z;
  const int32_t q = (j >> 1) & 3;
  const float sin_abs = (q & 1) ? c : s;
  const float cos_abs = (q & 1) ? s : c;
  float sin = (q & 2) ? -sin_abs : sin_abs;
  const float cos = (q == 1 || q == 2) ? -cos_abs : cos_abs;
  if (std::signbit(x)) sin = -sin;
  return {sin, cos};
}

// Relative error below 2e-7; 0 below -87.3, infinity above 88.7.
inline float Exp(float x) {
  if (!(x > -87.3f)) return x == x ? 0.0f : x;
  if (x > 88.7f) return kInfinity;
  const float k = std::floor(x * 1.44269504088896341f + 0.5f);
  const float r = (x - k * 0.693359375f) + k * 2.12194440e-4f;
  const float p = (((((1.9875691500e-4f * r + 1.3981999507e-3f) * r + 8.3334519073e-3f) * r + 4.1665795894e-2f) * r +
                    1.6666665459e-1f) *
                       r +
                   5.0000001201e-1f) *
                      r * r +
                  r + 1;
  const int32_t e = static_cast<int32_t>(k);
  // Two factors, so that the ends of the exponent range do not overflow on the way.
  const float half = std::bit_cast<float>(static_cast<uint32_t>((e / 2) + 127) << 23);
  const float rest = std::bit_cast<float>(static_cast<uint32_t>((e - e / 2) + 127) << 23);
  return p * half * rest;
}

// Natural logarithm; x > 0 and normal. Relative error below 2e-7 (absolute near 1).
inline float Log(float x) {
  if (!(x > 0)) return x == 0 ? -kInfinity : std::numeric_limits<float>::quiet_NaN();
  if (x == kInfinity) return x;
  if (x < 1.17549435e-38f) return Log(x * 8388608.0f) - 15.942385f;
  const uint32_t bits = std::bit_cast<uint32_t>(x);
  int32_t e = static_cast<int32_t>(bits >> 23) - 126;
  float m = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f000000u);  // [0.5, 1)
  if (m < 0.707106781186547524f) {
    --e;
    m = m + m - 1;
  } else {
    m = m - 1;
  }
  const float z = m * m;
  float y = ((((((((7.0376836292e-2f * m - 1.1514610310e-1f) * m + 1.1676998740e-1f) * m - 1.2420140846e-1f) * m +
                 1.4249322787e-1f) *
                    m -
                1.6668057665e-1f) *
                   m +
               2.0000714765e-1f) *
                  m -
              2.4999993993e-1f) *
                 m +
             3.3333331174e-1f) *
            m * z;
  const float fe = static_cast<float>(e);
  y += -2.12194440e-4f * fe - 0.5f * z;
  return m + y + 0.693359375f * fe;
}

// x >= 0.
inline float Pow(float x, float y) {
  if (y == 0) return 1;
  if (x == 0) return y > 0 ? 0.0f : kInfinity;
  return Exp(y * Log(x));
}

// [0, pi/2]-based arctangent of the full circle, result in (-pi, pi]; absolute error below 3e-7.
inline float Atan2(float y, float x) {
  const float ax = std::fabs(x), ay = std::fabs(y);
  const float hi = std::max(ax, ay), lo = std::min(ax, ay);
  if (hi == 0) return std::signbit(x) ? std::copysign(kPi, y) : y;
  float t = lo / hi;  // [0, 1]
  float base = 0;
  if (t > 0.4142135623730950f) {
    t = (t - 1) / (t + 1);
    base = kPi / 4;
  }
  const float z = t * t;
  float a =
      base +
      ((((8.05374449538e-2f * z - 1.38776856032e-1f) * z + 1.99777106478e-1f) * z - 3.33329491539e-1f) * z * t + t);
  if (ay > ax) a = kPi / 2 - a;
  if (std::signbit(x)) a = kPi - a;
  return std::copysign(a, y);
}

// x clamped to [-1, 1]; absolute error below 3e-7.
inline float Acos(float x) {
  x = std::clamp(x, -1.0f, 1.0f);
  return Atan2(std::sqrt((1 - x) * (1 + x)), x);
}
inline float Asin(float x) {
  x = std::clamp(x, -1.0f, 1.0f);
  return Atan2(x, std::sqrt((1 - x) * (1 + x)));
}
inline float Tan(float x) {
  const auto [sin, cos] = SinCos(x);
  return sin / cos;
}
inline float Radians(float degrees) {
  return degrees * (kPi / 180);
}

}  // namespace lodestar
