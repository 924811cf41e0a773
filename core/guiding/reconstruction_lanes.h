// The vectors of `native` reconstruction: eight floats, one for each concentration that it weighs
// (reconstruction_shrinkage.h), with the logarithm and the exponential it needs, and four, one for each child of a
// node. Branch-free, the same bits on every machine.
#pragma once

#include <immintrin.h>

#include <bit>
#include <cstdint>

namespace lodestar::directional {

// Compiler vectors (GCC, Clang): element-wise + - * /.
typedef float Lanes __attribute__((vector_size(32)));
typedef int32_t IntLanes __attribute__((vector_size(32)));
inline constexpr int kLanes = 8;

typedef float Quad __attribute__((vector_size(16)));
typedef double DoubleQuad __attribute__((vector_size(32)));
typedef uint32_t IndexQuad __attribute__((vector_size(16)));
typedef int64_t MaskQuad __attribute__((vector_size(32)));

inline Lanes Broadcast(float x) {
  return _mm256_set1_ps(x);
}
// a b + c, rounded once.
inline Lanes MultiplyAdd(Lanes a, Lanes b, Lanes c) {
  return _mm256_fmadd_ps(a, b, c);
}
// In every lane.
inline Lanes Sum(Lanes x) {
  x += __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3);
  x += __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5);
  return x + __builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6);
}
inline Lanes Max(Lanes x) {
  const auto larger = [](Lanes a, Lanes b) { return a > b ? a : b; };
  x = larger(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3));
  x = larger(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5));
  return larger(x, __builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6));
}
inline float Sum(Quad x) {
  return (x[0] + x[1]) + (x[2] + x[3]);
}
inline double Sum(DoubleQuad x) {
  return (x[0] + x[1]) + (x[2] + x[3]);
}

// x positive and normal; absolute error below 1e-6. The polynomial is that of least greatest error for log m, m within
// [sqrt(1/2), sqrt(2)): 2.1e-7.
inline Lanes Log(Lanes x) {
  constexpr int32_t kSqrtHalf = 0x3f3504f3;
  const IntLanes bits = std::bit_cast<IntLanes>(x) - kSqrtHalf;
  const IntLanes exponent = bits >> 23, mantissa = (bits & 0x007fffff) + kSqrtHalf;
  const Lanes t = std::bit_cast<Lanes>(mantissa) - 1;
  Lanes series = Broadcast(0.11827472f);
  for (const float c : {-0.189019774f, 0.206046744f, -0.248813397f, 0.333032982f, -0.500019651f, 1.00000325f})
    series = MultiplyAdd(series, t, Broadcast(c));
  return MultiplyAdd(series, t, __builtin_convertvector(exponent, Lanes) * 0.693147181f);
}

// x <= 0; below -80 as at -80. Relative error below 1e-5.
inline Lanes Exp(Lanes x) {
  const Lanes clamped = x < -80.0f ? Broadcast(-80.0f) : x;
  const Lanes t = clamped * 1.44269504f - 0.5f;
  const IntLanes k = __builtin_convertvector(t, IntLanes);  // towards zero: t is negative, so this is round(x log2 e)
  const Lanes r = clamped - __builtin_convertvector(k, Lanes) * 0.693147181f;
  Lanes p = Broadcast(1.0f / 120);
  for (const float c : {1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) p = MultiplyAdd(p, r, Broadcast(c));
  const IntLanes power = (k + 127) << 23;
  return p * std::bit_cast<Lanes>(power);
}

}  // namespace lodestar::directional
