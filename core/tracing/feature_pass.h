// What the camera sees first, without noise to speak of: the features that denoisers, compositors and people who study
// a guide ask for. A pass of its own after the render; the image does not depend on it.
//
// Each pixel is the mean of kFeatureSamples samples, which are the first of the render's own: same filter, lens and
// mixed materials. A function of scene, seed, method and state alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/learning/job.h"
#include "core/learning/method.h"
#include "core/math/sampler.h"
#include "core/scene/scene.h"

namespace lodestar {

inline constexpr uint32_t kFeatureSamples = Sampler::kBlockPasses;

// A surface along a ray.
struct SurfaceHit {
  SurfaceInteraction si;
  Bsdf bsdf;
  Vec3 wo;             // in the shading frame
  float distance = 0;  // along the ray
};

// Along a camera ray. `sampler` decides what is random: mixed materials.
std::optional<SurfaceHit> FirstSurface(const Scene& scene, const CameraRay& ray, Sampler& sampler);
// The first one with smooth lobes, through at most the scene's depth of mirrors and glass, whose lobe `sampler`
// chooses.
std::optional<SurfaceHit> FirstSmoothSurface(const Scene& scene, const CameraRay& ray, Sampler& sampler);

// How a method samples at a vertex.
struct TechniqueShares {
  float bsdf_fraction = 1;    // of directions that the BSDF draws; the guide draws the others
  float nee_probability = 1;  // share of vertices that sample a light; 0 where none does
};
using SharesAt = std::function<TechniqueShares(const SurfaceHit&)>;
// Throws Error(kUnsupported) for a method whose shares are not known here.
SharesAt SharesOf(const Scene& scene, const Method& method, const std::shared_ptr<const State>& state);

// Row by row from the top.
struct Features {
  uint32_t width = 0, height = 0;
  std::vector<Rgb> albedo;   // linear; 0 where nothing is hit
  std::vector<Vec3> normal;  // shading normal in world space, turned towards the camera; 0 where nothing is hit. A mean
                             // of unit vectors: shorter than 1 on edges
  std::vector<float> depth;  // along the ray, in the scene's unit, over the samples that hit; infinite where none does
  // At the first surface with smooth lobes, over the samples that found one; 0 where none did. No fraction is below
  // 0.05.
  std::vector<float> bsdf_fraction, nee;
};
// threads 0: UsableThreads().
Features RenderFeatures(const Scene& scene, uint64_t seed, const SharesAt& shares, int threads = 0);

}  // namespace lodestar
