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

  explicit SdTreeGuide(std::shared_ptr<const SdTreeState> state) : state_(std::move(state)), tree_(state_->tree()) {}

  Local At(const SurfaceInteraction& si, const Bsdf&, Vec3) const {
    Local local;
    local.leaf = tree_.LeafAt(si.p);
    if (tree_.HasLearned(local.leaf)) local.bsdf_fraction = tree_.BsdfFraction(local.leaf);
    return local;
  }
  GuidedSample Sample(const Local& local, Vec2 u, float) const { return tree_.Sample(local.leaf, u); }
  float Pdf(const Local& local, Vec3 wi) const { return tree_.Pdf(local.leaf, wi); }
  float Fluence(const Local& local) const { return tree_.leaf(local.leaf).mean_flux; }

  void Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* records, Statistics* statistics) const;

 private:
  std::shared_ptr<const SdTreeState> state_;
  const SdTree& tree_;
};

}  // namespace lodestar
