// The SD-tree as a guide, and what a path tells the next one.
#pragma once

#include <span>
#include <vector>

#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/guide.h"

namespace lodestar {

class SdTreeGuide {
 public:
  static constexpr bool kGuides = true, kRecords = true;
  struct Local {
    float bsdf_fraction = 1, nee_probability = 1;
    uint32_t leaf = 0;
  };
  using Scratch = std::vector<SdTreeRecord>;

  SdTreeGuide(std::shared_ptr<const SdTreeState> state, SdTreeMethod::Learn learn)
      : state_(std::move(state)), tree_(state_->tree()), learn_(learn) {}

  Local At(const SurfaceInteraction& si, const Bsdf&, Vec3) const {
    Local local;
    local.leaf = tree_.LeafAt(si.p);
    const SdTreeLeaf& leaf = tree_.leaf(local.leaf);
    if (leaf.learned) local.bsdf_fraction = leaf.bsdf_fraction;
    local.nee_probability = leaf.nee_probability;
    return local;
  }
  GuidedSample Sample(const Local& local, Vec2 u, float) const { return tree_.Sample(local.leaf, u); }
  float Pdf(const Local& local, Vec3 wi) const { return tree_.Pdf(local.leaf, wi); }
  float Fluence(const Local& local) const { return tree_.leaf(local.leaf).mean_flux; }
  float PixelLuminance(uint32_t x, uint32_t y) const { return state_->pixels().empty() ? 0.0f : state_->pixels().At(x, y); }

  void Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* records, Statistics* statistics) const;

 private:
  std::shared_ptr<const SdTreeState> state_;
  const SdTree& tree_;
  SdTreeMethod::Learn learn_;
};

}  // namespace lodestar
