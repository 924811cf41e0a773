// One path from the camera, with next event estimation, multiple importance sampling and (where compiled in) guiding by an SD-tree and recording for
// the next one. Specialised at compile time on what the method and the scene need.
//
// Estimator: unidirectional path tracing with the balance heuristic between light sampling and directional sampling (Veach 1997, section 9.2). A
// direction is drawn from the mixture alpha * BSDF + (1 - alpha) * tree (Mueller 2019, "Practical Path Guiding in Production", eq. 5); delta lobes
// are drawn by the BSDF alone.
#pragma once

#include <vector>

#include "core/base/health.h"
#include "core/guiding/sd_tree.h"
#include "core/guiding/sd_tree_statistics.h"
#include "core/math/sampler.h"
#include "core/scene/scene.h"

namespace lodestar {

// What a kernel is compiled for.
enum KernelFeature : unsigned {
  kGuide = 1,         // directions come from the mixture with the tree
  kRecord = 2,        // vertices are recorded for the next tree
  kEnvironment = 4,   // rays that leave the scene meet light
};
inline constexpr unsigned kKernelVariants = 8;

struct PathSettings {
  int max_depth = 5;             // bounces; as pbrt's maxdepth
  bool next_event = true;
  int roulette_start = 2;        // first bounce that may be ended by roulette
};

// Dimension pairs of a path: pixel, lens, then four a vertex: (roulette, mix), (lobe or technique, light), direction, position on the light.
inline constexpr uint32_t kFirstVertexPair = 2, kPairsPerVertex = 4;

// Roulette where the tree knows better than the throughput (docs/decisions/0006-roulette.md): a path's expected contribution is its throughput times
// the radiance that the tree expects along its new direction, fluence * p_tree. Only a path whose contribution falls below kWindow of what its pixel
// expects is at stake, after Vorba and Krivanek 2016 (without splitting); the defensive share and the least survival bound what a wrong tree can cost.
inline constexpr float kWindow = 0.1f, kLeastSurvival = 0.3f, kDefensive = 0.1f;

struct PathVertex {
  Rgb local{};  // radiance that leaves the vertex towards the camera without what arrives along wi: MIS-weighted emission and direct light
  Rgb weight{};  // f cos / pdf of wi
  float roulette = 1;  // what survival multiplied the rest of the path by; 0: the path was ended here
  Vec3 p{}, wi{};
  float pdf = 0, bsdf_pdf = 0, tree_pdf = 0, product = 0;
  uint32_t leaf = 0;
  bool recorded = false;  // a smooth vertex that has a wi
};

struct PathCounters {
  uint64_t paths = 0, rays = 0, vertices = 0;
};

// SceneT is Scene, or something that answers the same calls and watches them (bench/ray_replay.cpp).
template <unsigned kFeatures, class SceneT = Scene>
class PathKernel {
 public:
  PathKernel(const SceneT& scene, const PathSettings& settings, const SdTree* tree) : scene_(scene), settings_(settings), tree_(tree) {}

  // Radiance along the camera ray. With kRecord, `vertices` receives the path (its storage is reused from path to path).
  Rgb Trace(const CameraRay& camera_ray, Sampler& sampler, PathCounters* counters, std::vector<PathVertex>* vertices) const;

 private:
  // Density of the direction technique; bsdf_pdf is of smooth lobes.
  struct Technique {
    float bsdf_fraction = 1;
    uint32_t leaf = 0;
    float MixturePdf(float bsdf_pdf, float tree_pdf) const { return bsdf_fraction * bsdf_pdf + (1 - bsdf_fraction) * tree_pdf; }
  };
  Technique TechniqueAt(Vec3 p, bool smooth) const;
  Rgb DirectLight(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo, const Technique& technique, float u_light, Vec2 u, PathCounters* counters) const;

  const SceneT& scene_;
  const PathSettings settings_;
  const SdTree* tree_;
};

template <unsigned kFeatures, class SceneT>
inline typename PathKernel<kFeatures, SceneT>::Technique PathKernel<kFeatures, SceneT>::TechniqueAt(Vec3 p, bool smooth) const {
  Technique technique;
  if constexpr ((kFeatures & (kGuide | kRecord)) != 0) {
    if (smooth) technique.leaf = tree_->LeafAt(p);
  }
  if constexpr ((kFeatures & kGuide) != 0) {
    if (smooth && tree_->HasLearned(technique.leaf)) technique.bsdf_fraction = tree_->BsdfFraction(technique.leaf);
  }
  return technique;
}

template <unsigned kFeatures, class SceneT>
inline Rgb PathKernel<kFeatures, SceneT>::DirectLight(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo, const Technique& technique, float u_light,
                                              Vec2 u, PathCounters* counters) const {
  const auto light = scene_.SampleLight(si.p, u_light, u);
  if (!light) return {};
  const BsdfValue value = bsdf.Evaluate(wo, si.shading.ToLocal(light->wi));
  if (IsBlack(value.f_cos)) return {};
  ++counters->rays;
  const Vec3 origin = Scene::OffsetOrigin(si, light->wi);
  Ray ray{origin, light->wi, kInfinity};
  if (!light->infinite) {
    const Vec3 to_target = light->target - origin;
    ray.t_max = Length(to_target);
    ray.direction = to_target * (1 / ray.t_max);
  }
  if (!scene_.Unoccluded(ray)) return {};
  float weight = 1;
  if (!light->delta) {
    float pdf = value.pdf;
    if constexpr ((kFeatures & kGuide) != 0) {
      if (technique.bsdf_fraction < 1) pdf = technique.MixturePdf(pdf, tree_->Pdf(technique.leaf, light->wi));
    }
    weight = light->pdf / (light->pdf + pdf);
  }
  return value.f_cos * light->radiance * (weight / light->pdf);
}

template <unsigned kFeatures, class SceneT>
Rgb PathKernel<kFeatures, SceneT>::Trace(const CameraRay& camera_ray, Sampler& sampler, PathCounters* counters, std::vector<PathVertex>* vertices) const {
  constexpr bool kGuided = (kFeatures & kGuide) != 0, kRecording = (kFeatures & kRecord) != 0;
  Ray ray{camera_ray.origin, camera_ray.direction, kInfinity};
  Rgb radiance, beta(1);
  // What roulette looks at: the throughput this path would have if its directions had come from the BSDFs. A guide draws directions of much light often,
  // so their throughput is small although their contribution is not: roulette on it would undo the guiding. Without a guide it is the throughput.
  Rgb roulette_beta(1);
  // With a guide: what the pixel may expect of the light reflected by the first vertex that the tree knows, from its fluence and albedo.
  float expected = 0;
  float previous_pdf = 0;  // of the direction that led here; 0: a delta lobe or the camera, whose emission counts in full
  Vec3 previous_p;
  if constexpr (kRecording) vertices->clear();
  ++counters->paths;

  for (int depth = 0, passed = 0;;) {
    ++counters->rays;
    Hit hit;
    if (!scene_.Intersect(ray, &hit)) {
      if constexpr ((kFeatures & kEnvironment) != 0) {
        const EnvironmentSample environment = scene_.Environment(ray.direction);
        Rgb emitted = environment.radiance;
        if (previous_pdf > 0 && settings_.next_event) emitted *= previous_pdf / (previous_pdf + environment.pdf);
        radiance += beta * emitted;
        if constexpr (kRecording) vertices->push_back({.local = emitted, .weight = Rgb(0)});
      }
      break;
    }
    ++counters->vertices;
    const SurfaceInteraction si = scene_.Interaction(ray, hit);
    Rgb local;

    // Light that the surface itself gives.
    if (si.light >= 0) {
      local = scene_.Emitted(si, -ray.direction);
      if (previous_pdf > 0 && settings_.next_event && !IsBlack(local))
        local *= previous_pdf / (previous_pdf + scene_.LightPdf(previous_p, si, ray.direction));
    }
    sampler.StartAt(kFirstVertexPair + static_cast<uint32_t>(depth) * kPairsPerVertex);
    const Vec2 u_mix = sampler.Next2D(), u_choice = sampler.Next2D(), u_direction = sampler.Next2D();
    const Bsdf bsdf = scene_.BsdfAt(si, u_mix.y);
    if (bsdf.kind() == Bsdf::Kind::kNone) {
      // An interface without a medium: the ray goes on as if it were not there. Bounded, should a path graze a stack of them for ever.
      radiance += beta * local;
      if constexpr (kRecording) vertices->push_back({.local = local, .weight = Rgb(1)});
      if (++passed > 1000) break;
      ray.origin = Scene::OffsetOrigin(si, ray.direction);
      continue;
    }
    if (depth == settings_.max_depth) {
      radiance += beta * local;
      if constexpr (kRecording) vertices->push_back({.local = local, .weight = Rgb(0)});
      break;
    }

    // Light that reaches it straight from a source.
    const Vec3 wo = si.shading.ToLocal(-ray.direction);
    const bool smooth = bsdf.HasSmoothLobes();
    const Technique technique = TechniqueAt(si.p, smooth);
    if (smooth && settings_.next_event) local += DirectLight(si, bsdf, wo, technique, u_choice.y, sampler.Next2D(), counters);
    radiance += beta * local;

    // The next direction.
    Rgb weight;
    Vec3 wi;
    float pdf = 0, bsdf_pdf = 0, tree_pdf = 0, eta = 1;
    bool delta = false;
    if (!kGuided || u_choice.x < technique.bsdf_fraction) {
      const float u_lobe = kGuided ? std::min(u_choice.x / technique.bsdf_fraction, kOneMinusEpsilon) : u_choice.x;
      if (const auto sample = bsdf.Sample(wo, u_lobe, u_direction)) {
        wi = si.shading.ToWorld(sample->wi);
        delta = sample->delta;
        eta = sample->eta;
        bsdf_pdf = sample->pdf;
        weight = sample->weight;
        pdf = bsdf_pdf;
        if constexpr (kGuided) {
          if (technique.bsdf_fraction < 1) {
            if (delta) {
              pdf *= technique.bsdf_fraction;
              weight *= 1 / technique.bsdf_fraction;
            } else {
              tree_pdf = tree_->Pdf(technique.leaf, wi);
              pdf = technique.MixturePdf(bsdf_pdf, tree_pdf);
              weight *= bsdf_pdf / pdf;
            }
          }
        }
      }
    } else if constexpr (kGuided) {
      const auto sample = tree_->Sample(technique.leaf, u_direction);
      wi = sample.w;
      const Vec3 local_wi = si.shading.ToLocal(wi);
      const BsdfValue value = bsdf.Evaluate(wo, local_wi);
      tree_pdf = sample.pdf;
      bsdf_pdf = value.pdf;
      pdf = technique.MixturePdf(bsdf_pdf, tree_pdf);
      if (pdf > 0) weight = value.f_cos * (1 / pdf);
    }
    const bool ended = IsBlack(weight);
    if constexpr (kRecording) {
      vertices->push_back({.local = local, .weight = weight, .p = si.p, .wi = wi, .pdf = pdf, .bsdf_pdf = bsdf_pdf, .tree_pdf = tree_pdf,
                           .product = Luminance(weight) * pdf, .leaf = technique.leaf, .recorded = smooth && !delta && !ended});
    }
    if (ended) break;
    if constexpr (kGuided) {
      if (expected == 0 && technique.bsdf_fraction < 1)
        expected = Luminance(beta * bsdf.Albedo(wo)) * tree_->leaf(technique.leaf).mean_flux * (0.5f * kInvPi);
    }
    beta *= weight;
    // Refraction scales radiance by the square of the relative index; survival must not depend on that (as pbrt).
    roulette_beta *= weight * (eta * eta);
    if constexpr (kGuided) roulette_beta *= delta ? technique.bsdf_fraction : bsdf_pdf > 0 ? pdf / bsdf_pdf : 1.0f;
    ++depth;

    if (depth >= settings_.roulette_start) {
      float survival = MaxComponent(roulette_beta);
      if constexpr (kGuided) {
        if (expected > 0 && tree_pdf > 0) {
          const float contribution = Luminance(beta) * tree_->leaf(technique.leaf).mean_flux * Lerp(kDefensive, tree_pdf, kUniformSpherePdf);
          survival = std::max(contribution / (kWindow * expected), kLeastSurvival);
        }
      }
      if (survival < 1) {
        if (!(u_mix.x < survival)) {
          if constexpr (kRecording) vertices->back().roulette = 0;
          break;
        }
        beta *= 1 / survival;
        roulette_beta *= 1 / survival;
        if constexpr (kRecording) vertices->back().roulette = 1 / survival;
      }
    }
    previous_pdf = delta ? 0 : pdf;
    previous_p = si.p;
    ray = {Scene::OffsetOrigin(si, wi), wi, kInfinity};
  }
  return radiance;
}

}  // namespace lodestar
