// The SD-tree: where light comes from, over space and direction (Mueller et al. 2017, "Practical Path Guiding for
// Efficient Light-Transport Simulation"). An immutable state: every worker of an iteration samples from the same bits
// and records into SdTreeStatistics; Advance() makes the next one.
//
// Each spatial leaf owns a D-tree, whose one topology carries both the sampling probabilities and the slots that are
// recorded into (docs/decisions/0002-exact-sums.md). Directions and densities are in the space of the positions;
// densities per steradian.
#pragma once

#include <memory>
#include <span>

#include "core/base/huge_pages.h"
#include "core/guiding/directional_tree.h"
#include "core/guiding/sd_tree_options.h"
#include "core/guiding/spatial_tree.h"

namespace lodestar {

struct GuidedSample {
  Vec3 w;
  float pdf;  // solid angle; exactly what Pdf() returns for w
};

// What a spatial leaf carries beside its D-tree.
struct SdTreeLeaf {
  uint32_t first_node = 0, node_count = 1;  // of its D-tree, in the state's pool
  float bsdf_fraction = 0.5f;
  float records = 0;    // records of the last iteration (halved by splits)
  float mean_flux = 0;  // their mean of radiance / pdf: an estimate of the incident radiance's integral over the sphere
  float nee_probability = 1;  // share of vertices that sample a light
  uint8_t learned = 0;        // 0: the D-tree is uniform for want of records
  uint8_t depth = 1;          // of the D-tree
};

// The pieces of a state; SdTree's constructor checks that they fit together.
struct SdTreeParts {
  SdTreeOptions options;
  Vec3 corner;
  float size = 1;
  uint32_t iteration = 0;
  float radiance_scale = 1;     // a power of two
  std::vector<uint8_t> depths;  // of the spatial leaves, depth first
  LargeVector<SdTreeLeaf> leaves;
  LargeVector<DirectionalNode> nodes;
  // Of the scene's groups of lights, in units of 2^-16 (light_selection.h): by power, and each leaf's. Empty where
  // light selection is not learned.
  std::vector<uint16_t> lights_by_power, lights;
};

class SdTree {
 public:
  // One leaf, uniform. Throws Error(kInvalidInput) for bounds that are empty or not finite, or bad options.
  // light_groups: probabilities by power, for learning to select lights; fewer than two are not worth it and are left
  // out.
  static std::shared_ptr<const SdTree> Initial(const Bounds3& bounds, const SdTreeOptions& options,
                                               std::span<const float> light_groups = {});
  explicit SdTree(SdTreeParts parts);

  // Positions outside the bounds belong to the nearest leaf.
  uint32_t LeafAt(Vec3 p) const { return spatial_.LeafAt(p); }

  // u in [0, 1)^2 with 24 bits. The density is never zero (but for underflow).
  GuidedSample Sample(uint32_t leaf, Vec2 u) const {
    const DirectionalNode* const tree = Tree(leaf);
    const directional::Point point = directional::Sample(tree, u);
    const Vec3 w = CylindricalToDirection(point.square);
    if (!point.near_border) [[likely]]
      return {w, point.density};
    // Near a border the direction may round into the next cell, which the tree means to reach with another density:
    // over many samples that would bias what lies there. Such a sample moves to the middle of its cell, of which a
    // direction's bits cannot miss.
    if (Pdf(leaf, w) == point.density) [[likely]]
      return {w, point.density};
    const Vec3 inner = CylindricalToDirection(point.inner);
    return {inner, Pdf(leaf, inner)};
  }
  // w of unit length.
  float Pdf(uint32_t leaf, Vec3 w) const { return directional::Locate(Tree(leaf), DirectionToCylindrical(w)).density; }

  // Asks for what Sample() and Pdf() will read, for when something else is to be done first.
  void Prefetch(uint32_t leaf) const { directional::Prefetch(Tree(leaf)); }

  float BsdfFraction(uint32_t leaf) const { return leaves_[leaf].bsdf_fraction; }
  bool HasLearned(uint32_t leaf) const { return leaves_[leaf].learned != 0; }

  const SdTreeOptions& options() const { return options_; }
  uint32_t iteration() const { return iteration_; }
  // What this iteration records; a full target needs a pixel estimate, which the first iteration has not.
  SdTreeOptions::Target target() const;
  float radiance_scale() const { return radiance_scale_; }
  uint32_t leaf_count() const { return spatial_.leaf_count(); }
  uint32_t node_count() const { return static_cast<uint32_t>(nodes_.size()); }
  const SpatialTree& spatial() const { return spatial_; }
  const SdTreeLeaf& leaf(uint32_t leaf) const { return leaves_[leaf]; }
  const DirectionalNode* Tree(uint32_t leaf) const { return nodes_.data() + leaves_[leaf].first_node; }
  // Probabilities of the groups of lights, in units of 2^-16; empty where they are not learned.
  std::span<const uint16_t> Lights(uint32_t leaf) const {
    return {lights_.data() + leaf * lights_by_power_.size(), lights_by_power_.size()};
  }
  std::span<const uint16_t> lights_by_power() const { return lights_by_power_; }
  Bounds3 LeafBounds(uint32_t leaf) const { return spatial_.LeafBounds(leaf); }
  size_t memory() const {
    return spatial_.memory() + leaves_.size() * sizeof(SdTreeLeaf) + nodes_.size() * sizeof(DirectionalNode) +
           lights_.size() * sizeof(uint16_t);
  }
  // A hash of the content, for telling states apart; not a content address.
  uint64_t fingerprint() const { return fingerprint_; }

  // Canonical: equal trees have equal bytes.
  Bytes Serialize() const;
  // Throws Error(kCorrupt) for anything but what Serialize() wrote.
  static std::shared_ptr<const SdTree> Parse(std::string_view bytes);

 private:
  SdTreeOptions options_;
  uint32_t iteration_ = 0;
  float radiance_scale_ = 1;
  SpatialTree spatial_;
  LargeVector<SdTreeLeaf> leaves_;
  LargeVector<DirectionalNode> nodes_;
  std::vector<uint16_t> lights_by_power_, lights_;
  uint64_t fingerprint_ = 0;
};

}  // namespace lodestar
