// Settings of focal guiding (Rath et al. 2023; Sadek 2025, chapter 3). The defaults are Sadek's and the recommendation,
// but where said.
#pragma once

#include <cstdint>

#include "core/base/bytes.h"

namespace lodestar {

struct FocalOptions {
  // Below this a hit mirrors or refracts well enough for an image to be seen behind it (Rath et al. 2023).
  static constexpr float kImageRoughness = 0.3f;

  int start_depth = 3;            // levels of the uniform octree to begin with; 1 to 6
  int initial_iterations = 6;     // spread each path segment evenly over the voxels it crosses; 1 to 30
  int narrowing_iterations = 6;   // spread it by what each voxel contributes to its density, and split; 0 to 30
  float narrow_factor = 1;        // n: the power of that contribution, above 1 narrows faster; 0.25 to 8
  bool by_mixture = true;         // narrowing weighs a segment by the share of its density that is the guide's (Rath et
                                  // al.'s own program); false: in full (Sadek)
  float split_threshold = 1e-3f;  // gamma: a voxel splits above this share of the whole mass; 1e-5 to 1
  float prune_ratio = 2;       // a subtree whose densest leaf is no denser than this times its mean collapses; 0: never
  float decay = 0.5f;          // what is left of the previous iterations' masses after each; 0 to 1
  bool images = true;          // a segment goes on straight behind a smooth hit, where virtual images are
  bool diverging = false;      // a second octree for the places that directions come from instead of leading to
  float bsdf_fraction = 0.5f;  // share of directions that the BSDF samples, within [0.05, 0.95]
  bool learn_fraction = false;   // that share is learned per cell of a coarse grid, starting from it
  uint32_t max_nodes = 1 << 16;  // of each octree, 8 voxels each: 160 bytes a node in every accumulator that touches it

  uint32_t iterations() const { return static_cast<uint32_t>(initial_iterations + narrowing_iterations); }
  bool Narrows(uint32_t iteration) const { return iteration >= static_cast<uint32_t>(initial_iterations); }

  // Throws Error(kInvalidInput) naming the setting.
  void Validate() const;
  void Write(ByteWriter& out) const;
  // Throws Error(kCorrupt).
  static FocalOptions Read(ByteReader& in);
  friend bool operator==(const FocalOptions&, const FocalOptions&) = default;
};

}  // namespace lodestar
