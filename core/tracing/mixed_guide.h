// SD-tree and focal field as one guide (core/learning/mixed_guiding.h).
#pragma once

#include "core/learning/mixed_guiding.h"
#include "core/tracing/focal_guide.h"
#include "core/tracing/sd_tree_guide.h"

namespace lodestar {

class MixedGuide {
 public:
  static constexpr bool kGuides = true, kRecords = true, kUsesAlpha = true, kDefersDensities = false;
  struct Local : SdTreeGuide<false>::Local {  // its bsdf_fraction is alpha beta
    Vec3 p;
    float tree_share = 1;  // of what the BSDF does not draw
  };
  struct Scratch {
    SdTreeGuide<false>::Scratch tree;
    std::vector<PathVertex> vertices;
  };

  MixedGuide(const std::shared_ptr<const MixedState>& state, SdTreeMethod::Learn learn)
      : tree_(state->tree(), learn), focal_(state->focal()), field_(state->focal()->field()) {}

  Local At(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) const {
    Local local{tree_.At(si, bsdf, wo), si.p};
    const Shares shares = SharesAt(local.bsdf_fraction, si.p);
    local.bsdf_fraction = shares.bsdf;
    local.tree_share = shares.tree;
    return local;
  }
  GuidedSample Sample(const Local& local, Vec2 u, float u_more) const {
    GuidedSample sample;
    if (u_more < local.tree_share) {
      sample = tree_.Sample(local, u, 0);
      if (local.tree_share < 1) sample.pdf = Lerp(local.tree_share, field_.Pdf(local.p, sample.w), sample.pdf);
    } else {
      const FocalSample focal = field_.Sample(local.p, u);
      sample = {focal.w, focal.pdf};
      if (local.tree_share > 0) sample.pdf = Lerp(local.tree_share, focal.pdf, tree_.Pdf(local, focal.w));
    }
    return sample;
  }
  float Pdf(const Local& local, Vec3 wi) const {
    const float focal = local.tree_share < 1 ? field_.Pdf(local.p, wi) : 0;
    const float tree = local.tree_share > 0 ? tree_.Pdf(local, wi) : 0;
    return Lerp(local.tree_share, focal, tree);
  }
  float Fluence(const Local& local) const { return tree_.Fluence(local); }
  float Radiance(const Local& local, Vec3 wi, float) const { return tree_.Radiance(local, wi, tree_.Pdf(local, wi)); }
  float PixelLuminance(uint32_t x, uint32_t y) const { return tree_.PixelLuminance(x, y); }

  void Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* scratch,
              Statistics* statistics) const;

 private:
  struct Shares {
    float bsdf, tree;
  };
  // From the tree's own fraction alpha, 1 where it has not learned.
  Shares SharesAt(float alpha, Vec3 p) const {
    const float beta = field_.HasLearned() ? field_.BsdfFraction(p) : 1;
    const float bsdf = alpha * beta;
    return {bsdf, bsdf < 1 ? beta * (1 - alpha) / (1 - bsdf) : 1};
  }

  SdTreeGuide<false> tree_;
  FocalGuide focal_;
  const FocalField& field_;
};

}  // namespace lodestar
