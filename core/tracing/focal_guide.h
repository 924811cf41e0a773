// The focal field as a guide, and what a path tells the next one.
#pragma once

#include <span>

#include "core/learning/focal_guiding.h"
#include "core/tracing/guide.h"

namespace lodestar {

class FocalGuide {
 public:
  static constexpr bool kGuides = true, kRecords = true, kUsesAlpha = true, kDefersDensities = true;
  struct Local {
    float bsdf_fraction = 1, nee_probability = 1;
    uint32_t leaf = 0;
    static constexpr LightGroupWeights lights{};
    Vec3 p;
  };
  struct Scratch {};

  explicit FocalGuide(std::shared_ptr<const FocalState> state) : state_(std::move(state)), field_(state_->field()) {}

  Local At(const SurfaceInteraction& si, const Bsdf&, Vec3) const {
    Local local;
    local.p = si.p;
    if (field_.HasLearned()) local.bsdf_fraction = field_.BsdfFraction(si.p);
    return local;
  }
  GuidedSample Sample(const Local& local, Vec2 u, float) const {
    const FocalSample sample = field_.Sample(local.p, u);
    return {sample.w, sample.pdf};
  }
  Vec3 Direction(const Local& local, Vec2 u) const { return field_.Direction(local.p, u); }
  float Pdf(const Local& local, Vec3 wi) const { return field_.Pdf(local.p, wi); }
  float Fluence(const Local&) const { return 0; }
  float Radiance(const Local&, Vec3, float) const { return 0; }
  float PixelLuminance(uint32_t, uint32_t) const { return 0; }

  void Record(std::span<const PathVertex> vertices, const PixelSample&, Scratch*, Statistics* statistics) const;

 private:
  std::shared_ptr<const FocalState> state_;
  const FocalField& field_;
};

}  // namespace lodestar
