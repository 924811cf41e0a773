// The learned share q of vertices that sample a light. A light sample costs a shadow ray and a BSDF evaluation; behind
// a wall it never pays.
//
// A vertex's estimate is nee / q + reflected, the light sample taken with probability q. With M_n the second moment of
// the light sample at q = 1, V_r the variance of the rest and m_n the light sample's mean, variance times cost is (M_n
// / q + V_r - m_n^2)(q c_n + c_r), c_n and c_r the costs of the light sample and of the rest of the path. Its minimum
// is q^2 = M_n c_r / ((V_r - m_n^2) c_n): the efficiency-optimal roulette of Bolin and Meyer 1997 for one decision. q
// stays positive, so the estimate stays unbiased whatever was learned, and the balance heuristic knows q.
#pragma once

#include <cstdint>

#include "core/math/exact_sum.h"

namespace lodestar {

// What was not seen in training may be there: the least share bounds the excess variance to its inverse.
inline constexpr float kLeastNeeProbability = 0.1f;

// Sums of one spatial leaf, of scaled luminances.
struct NeeSums {
  ExactSum direct, direct_squared, reflected, reflected_squared;
  uint64_t vertices = 0;  // of the paths from here on
  uint64_t count = 0;

  void Add(float direct_light, float reflected_light, uint32_t path_vertices);
  void Merge(const NeeSums& other);
};

// `previous`: the share in use while the sums were made. Fewer records than `min_records` keep it.
float SolveNeeProbability(const NeeSums& sums, float previous, double min_records);

}  // namespace lodestar
