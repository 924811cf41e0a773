// Russian roulette of paths. Where the tree knows better than the throughput (docs/decisions/0006-roulette.md), a
// path's expected contribution is its throughput times the radiance that the tree expects along its new direction,
// fluence * p_tree, and only a path whose contribution falls below kWindow of what its pixel expects is at stake, after
// Vorba and Krivanek 2016 (without splitting); the guide's defensive share and the least survival bound what a wrong
// tree can cost.
#pragma once

#include <algorithm>

#include "core/math/rgb.h"

namespace lodestar {

inline constexpr float kWindow = 0.1f, kLeastSurvival = 0.3f;

// Both luminances, expected > 0. The probability of going on, in [kLeastSurvival, 1]; above 1: certain.
inline float SurvivalByContribution(float contribution, float expected) {
  return std::max(contribution / (kWindow * expected), kLeastSurvival);
}

// What the throughput is multiplied by, u in [0, 1): 0 where the path ends, else the inverse of the survival, so that
// its mean over u is 1. A survival that is no number ends nothing: the light that it comes with is to be seen.
inline float RouletteWeight(float survival, float u) {
  if (!(survival < 1)) return 1;
  return u < survival ? 1 / survival : 0.0f;
}

// What the survival of one path depends on.
struct PathRoulette {
  // That the path would have if its directions had come from the BSDFs. A guide draws directions of much light often,
  // so their throughput is small although their contribution is not: roulette on it would undo the guiding. Without a
  // guide it is the throughput.
  Rgb throughput{1};
  float expected = 0;  // of the pixel; 0: not known
  // What the rest of the path should add, as the guide has it at the last vertex with smooth lobes: what comes through
  // glass is bright for the reason that its direction was chosen. 0: not known.
  float contribution = 0;

  // What the path is multiplied by; 0: it ends.
  float Survive(float u) {
    const bool known = expected > 0 && contribution > 0;
    const float weight =
        RouletteWeight(known ? SurvivalByContribution(contribution, expected) : MaxComponent(throughput), u);
    throughput *= weight;
    contribution *= weight;
    return weight;
  }
};

}  // namespace lodestar
