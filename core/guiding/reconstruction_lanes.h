// Eight floats at a time, one for each concentration that `native` weighs (reconstruction_shrinkage.h), with the
// logarithm and the exponential it needs: branch-free, the same bits on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace lodestar::directional {

// Compiler vectors (GCC, Clang): element-wise + - * /.
typedef float Lanes __attribute__((vector_size(32)));
typedef int32_t IntLanes __attribute__((vector_size(32)));
inline constexpr int kLanes = 8;

inline Lanes Broadcast(float x) {
  return Lanes{} + x;
}
inline float Sum(Lanes x) {
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}
inline float Max(Lanes x) {
  float max = x[0];
  for (int i = 1; i < kLanes; ++i) max = x[i] > max ? x[i] : max;
  return max;
}

// x positive and normal; absolute error below 1e-6. log m = 2 artanh((m - 1) / (m + 1)), m within [sqrt(1/2), sqrt(2)).
inline Lanes Log(Lanes x) {
  constexpr int32_t kSqrtHalf = 0x3f3504f3;
  const IntLanes bits = std::bit_cast<IntLanes>(x) - kSqrtHalf;
  const IntLanes exponent = bits >> 23, mantissa = (bits & 0x007fffff) + kSqrtHalf;
  const Lanes m = std::bit_cast<Lanes>(mantissa);
  const Lanes s = (m - 1) / (m + 1), ss = s * s;
  const Lanes series = ((ss * (2.0f / 7) + 2.0f / 5) * ss + 2.0f / 3) * ss + 2.0f;
  return series * s + __builtin_convertvector(exponent, Lanes) * 0.693147181f;
}

// x <= 0; below -80 as at -80. Relative error below 1e-5.
inline Lanes Exp(Lanes x) {
  const Lanes clamped = x < -80.0f ? Broadcast(-80.0f) : x;
  const Lanes t = clamped * 1.44269504f - 0.5f;
  const IntLanes k = __builtin_convertvector(t, IntLanes);  // towards zero: t is negative, so this is round(x log2 e)
  const Lanes r = clamped - __builtin_convertvector(k, Lanes) * 0.693147181f;
  const Lanes p = ((((r * (1.0f / 120) + 1.0f / 24) * r + 1.0f / 6) * r + 0.5f) * r + 1) * r + 1;
  const IntLanes power = (k + 127) << 23;
  return p * std::bit_cast<Lanes>(power);
}

}  // namespace lodestar::directional
