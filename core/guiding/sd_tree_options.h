// Settings of the SD-tree (Mueller et al. 2017; "Practical Path Guiding in Production" 2019). What is not set is plain:
// the presets say what to use.
#pragma once

#include <cstdint>

#include "core/base/bytes.h"

namespace lodestar {

struct SdTreeOptions {
  // Which spatial leaves a record goes to: the one that holds it; the one that holds a point jittered by the leaf's
  // size; all that overlap a box of the leaf's size around it, by volume. Stochastic has the box filter's expectation
  // at the cost of one lookup.
  enum class SpatialFilter : uint8_t { kNearest, kStochastic, kBox };
  // The same in the directional quadtree: nearest cell, or all cells under a footprint of the cell's own size.
  enum class DirectionalFilter : uint8_t { kNearest, kBox };
  // What the learned share of BSDF sampling minimises; kNone keeps initial_bsdf_fraction. KL is robust to outliers.
  enum class BsdfFractionLoss : uint8_t { kNone, kKl, kVariance };

  // What the directional trees are proportional to (Rath et al. 2020, "Variance-Aware Path Guiding"; Mueller et al.
  // 2017). Radiance: the incident radiance. Simple: the root of the second moment of f cos L, so that what f cos weighs
  // down, and what has no noise, is guided to less. Full: the same of a path's contribution relative to its pixel, so
  // that dark pixels count as much as bright ones. Switching: simple, and full from the fourth training iteration after
  // the first on (Nilsson 2023, section 4.3), as full needs pixel estimates that the first iterations do not have.
  enum class Target : uint8_t { kRadiance, kSimple, kFull, kSwitching };
  // How a tree is made from its sums: as they are; by hierarchical Gaussian filtering of dense matrices (Nilsson 2023)
  // within the document's limit on its cost, or whatever it costs; or on the tree itself with a width found by
  // cross-validation (docs/decisions/0008-reconstruction.md).
  enum class Reconstruction : uint8_t { kNone, kDense, kNative, kDenseUnlimited };

  // c: a spatial leaf splits above c * sqrt(samples per pixel of the iteration / 4) records; 500 to 20000
  float spatial_threshold = 4000;
  float flux_threshold = 0.01f;    // rho: a directional cell splits above this share of its tree's flux; 0.001 to 1
  int max_directional_depth = 20;  // 1 to 20
  int max_spatial_depth = 48;      // binary levels, 0 to 63: every third halves the same axis
  SpatialFilter spatial_filter = SpatialFilter::kStochastic;
  DirectionalFilter directional_filter = DirectionalFilter::kBox;
  BsdfFractionLoss bsdf_fraction_loss = BsdfFractionLoss::kKl;
  float initial_bsdf_fraction = 0.5f;  // within [0.05, 0.95]
  Target target = Target::kRadiance;
  Reconstruction reconstruction = Reconstruction::kNone;
  float dense_sigma = 0.5f;  // of kDense's Gaussian, in cells of its layer; 0.1 to 3
  bool learn_nee = false;    // learn the share of vertices that sample a light, per leaf
  float min_records = 128;  // a leaf with fewer records keeps its previous distribution; 1 is the papers' behaviour but
                            // for empty leaves
  // Of all directional trees together (16 bytes each, 64 more in every accumulator that touches them). What would be
  // beyond is left out: fewer leaves split, and trees are up to four times as coarse (sd_tree_advance.h).
  uint64_t max_nodes = uint64_t{1} << 22;

  static SdTreeOptions Recommended();  // what docs/decisions/0014-sd-tree-defaults.md found best
  static SdTreeOptions Paper2017();
  static SdTreeOptions Paper2019();

  // Throws Error(kInvalidInput) naming the setting.
  void Validate() const;
  void Write(ByteWriter& out) const;
  // Throws Error(kCorrupt).
  static SdTreeOptions Read(ByteReader& in);
  friend bool operator==(const SdTreeOptions&, const SdTreeOptions&) = default;
};

}  // namespace lodestar
