// For tests of the path kernel: a guide that has learned nothing and draws its directions as a diffuse surface does.
#pragma once

#include "core/tracing/guide.h"

namespace lodestar {

struct CosineGuide {
  static constexpr bool kGuides = true, kUsesAlpha = true, kDefersDensities = false;
  float bsdf_fraction = 0.5f;

  struct Local {
    float bsdf_fraction = 1, nee_probability = 1;
    LightGroupWeights lights{};
    uint32_t leaf = 0;  // the material
    Frame frame;
  };
  Local At(const SurfaceInteraction& si, const Bsdf&, Vec3) const {
    return {.bsdf_fraction = bsdf_fraction, .leaf = si.material, .frame = si.shading};
  }
  GuidedSample Sample(const Local& local, Vec2 u, float) const {
    const Vec3 w = SquareToCosineHemisphere(u);
    return {local.frame.ToWorld(w), CosineHemispherePdf(w.z)};
  }
  float Pdf(const Local& local, Vec3 wi) const { return CosineHemispherePdf(local.frame.ToLocal(wi).z); }
  float Fluence(const Local&) const { return 0; }
  float Radiance(const Local&, Vec3, float) const { return 0; }
};

}  // namespace lodestar
