// Reconstruction of D-trees: what was recorded in few samples is smoothed before it guides (Nilsson 2023). Two methods,
// `dense` the document's own and `native` ours; docs/decisions/0008-reconstruction.md compares them.
//
// Both take the masses of the cells of the tree that was recorded into and return the tree of the next iteration, in
// place of directional::Rebuild, with its limits on depth and nodes. Trees are independent of each other: both
// functions are pure and may run in parallel. Results depend on the ratios of the masses alone; a common factor that is
// a power of two changes no bit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/guiding/directional_tree.h"

namespace lodestar::directional {

// Masses of the target per slot (4 node + child) of a tree: finite, not negative, zero in slots that have a child node.
struct CellMasses {
  const DirectionalNode* nodes = nullptr;
  uint32_t node_count = 0;
  std::vector<double> total;  // sum > 0
  // The same target from each of two disjoint, independent halves of the records; both empty where not kept. They need
  // not add up to the total (square roots of sums do not), nor have its scale.
  std::array<std::vector<double>, 2> halves;
};

// The document's method (its chapter 4): every layer of the tree from depth 6 to its deepest as a square matrix,
// blurred by a 7 x 7 Gaussian with zeros outside; the element-wise maximum over the layers; rebuilt with a flux
// threshold that may differ from the one used for recording. Trees shallower than 6 or deeper than kMaxDenseDepth are
// only rebuilt. sigma: the Gaussian's standard deviation, in cells of each layer; 0.3 (hardly a change) to 1. The
// document picks it per scene and shows 0.8.
Tree ReconstructDense(const CellMasses& masses, float sigma, double flux_threshold, int max_depth);
inline constexpr int kMinDenseDepth = 6;
inline constexpr int kMaxDenseDepth = 12;  // two matrices of 64 MiB

// The document's limit on `dense` (its section 4.5): which trees to reconstruct, given the depths of all trees of a
// state. None deeper than 10, and matrix elements of all layers of all trees together at most 1.5e7 * 2^iteration.
// Where they do not all fit, the shallowest are taken first, which serves the most trees; ties in order.
std::vector<uint8_t> WithinWorkload(std::span<const int> depths, int iteration);

// Ours, the recommended one: works on the quadtree, without matrices and without a setting. Each node's shares are
// shrunk towards what the squares around it predict, across phi = 0 and the poles, by as much as the two halves of the
// records say that they are noise; then every cell has at least a part of what the coarser layers have there, as great
// a part as lowers the second moment that guiding is expected to have. Without halves, and where noise is too small for
// smoothing to gain, the tree is only rebuilt. Before that maximum over layers, the flux threshold and the nodes'
// integers no density falls below 0.37 of the unsmoothed one.
Tree ReconstructNative(const CellMasses& masses, double flux_threshold, int max_depth);

}  // namespace lodestar::directional
