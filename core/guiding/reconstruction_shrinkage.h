// How far the shares of a node's four children can be trusted: the statistical half of `native` reconstruction, a Polya
// tree (Lavine 1992) whose concentrations form a hidden Markov tree (Crouse et al. 1998). Derived in
// docs/decisions/0008-reconstruction.md.
#pragma once

#include <memory>

#include "core/guiding/reconstruction.h"
#include "core/guiding/reconstruction_lanes.h"

namespace lodestar::directional {

// A recorded node among those of its tree, level by level: parents come long before their children, so what one waits
// for the other for is done by then.
struct LevelNode {
  DoubleQuad share;  // of the children: the mass in and below them, of the total's
  IndexQuad child;   // places in this order; 0: a cell
  uint32_t node;     // in the recorded tree
  uint32_t parent;   // 4 place + child
  // Which part of the children's shares to take from what their neighbourhood predicts, 0 to 1.
  float weight;
  float per_record;  // mass of one effective record in and below it, of the total's
};

struct Shrinkage {
  std::unique_ptr<LevelNode[]> nodes;
  // The noise is too small for any smoothing to gain: weights are not inferred.
  bool needless = false;
};

// What a tree must have to gain before its widths are looked into: nats of Kullback-Leibler divergence. The second
// moment of guided estimates exceeds its least by about twice that.
inline constexpr double kLeastGain = 1.0 / 512;

Shrinkage InferShrinkage(const CellMasses& masses);

}  // namespace lodestar::directional
