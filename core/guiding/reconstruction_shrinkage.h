// How far the shares of a node's four children can be trusted: the statistical half of `native` reconstruction, a Polya
// tree (Lavine 1992) whose concentrations form a hidden Markov tree (Crouse et al. 1998). Derived in
// docs/decisions/0008-reconstruction.md.
#pragma once

#include "core/guiding/reconstruction.h"

namespace lodestar::directional {

struct Shrinkage {
  std::vector<double> share;  // per slot: the mass in and below it, of the total's
  // Per node: which part of its children's shares to take from what their neighbourhood predicts, 0 to 1. Empty where
  // the noise is too small for any smoothing to gain.
  std::vector<float> weight;
};

// What a tree must have to gain before its widths are looked into: nats of Kullback-Leibler divergence. The second
// moment of guided estimates exceeds its least by about twice that.
inline constexpr double kLeastGain = 1.0 / 512;

Shrinkage InferShrinkage(const CellMasses& masses);

}  // namespace lodestar::directional
