// Which lights a place samples, learned: a distribution over the scene's groups of lights for each spatial leaf.
//
// A light sample is taken with probability q, of group g with probability P_g, and then contributes d = X_g / (q P_g),
// X_g its MIS-weighted contribution before those divisions. Its second moment, sum of E[X_g^2] / (q P_g), is least for
// P_g proportional to sqrt(E[X_g^2]) (Lagrange; as in importance sampling of strata). A sample of group g adds d^2 P_g
// q, whose mean over all vertices is E[X_g^2]: samples that find nothing add nothing, and no count is needed, as only
// ratios matter.
//
// The MIS weight of X_g itself falls with P_g. By the balance heuristic a sample is f L / (q P_g p_g + p), p the
// directional density, for both techniques, and the second moment's derivative by P_g is -q E[d^2 | g]: in the optimum
// that is the same for every group, and where it is, the rule above returns P_g. So iterating it has the true optimum
// as its fixed point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/exact_sum.h"

namespace lodestar {

// Part of the distribution by power in what is learned: a light that training missed is sampled at least that often.
inline constexpr double kLightsByPower = 0.25;
inline constexpr size_t kMostLightGroups = 255;

// Probabilities in units of 2^-16: none is 0, their sum is 2^16. From at least two shares, positive or zero, of
// positive sum.
std::vector<uint16_t> QuantizeShares(std::span<const double> shares);

// The next distribution: of the sums of d^2 P_g q by group, mixed with that by power. Nothing but zeros keeps
// `previous`.
std::vector<uint16_t> SolveLightSelection(std::span<const ExactSum> sums, std::span<const uint16_t> by_power,
                                          std::span<const uint16_t> previous);

}  // namespace lodestar
