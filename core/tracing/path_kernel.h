// One path from the camera, with next event estimation, multiple importance sampling and (where compiled in) a guide
// and recording for its next state. Specialised at compile time on what the method and the scene need.
//
// Estimator: unidirectional path tracing with the balance heuristic between light sampling and directional sampling
// (Veach 1997, section 9.2). A direction is drawn from the mixture alpha * BSDF + (1 - alpha) * guide (Mueller 2019,
// "Practical Path Guiding in Production", eq. 5); delta lobes are drawn by the BSDF alone.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "core/learning/nee.h"
#include "core/learning/roulette.h"
#include "core/math/sampler.h"
#include "core/tracing/guide.h"
#include "core/tracing/path_roulette.h"

namespace lodestar {

// What a kernel is compiled for, beside its guide.
enum KernelFeature : unsigned {
  kRecord = 1,       // vertices are kept for the next state
  kEnvironment = 2,  // rays that leave the scene meet light
  kTextures = 4,     // some BSDFs are made at the hit, from textures or of a mix's parts
  kSpecular = 8,     // some surfaces have delta lobes
};
inline constexpr unsigned kKernelVariants = 16;

// All but kRecord, which the round decides. Alpha is not among them: meshes that have it bring their filter to the
// intersector, others pay nothing (accelerator.cpp).
inline unsigned KernelFeatures(const SceneNeeds& needs) {
  return (needs.environment ? kEnvironment : 0u) | (needs.BsdfsAtHits() ? kTextures : 0u) |
         (needs.delta_lobes ? kSpecular : 0u);
}

// Calls `call` with these features as a std::integral_constant. Those outside kMask have no variants.
template <unsigned kMask, unsigned kFeatures = 0, class Call>
auto WithFeatures(unsigned features, Call&& call) {
  constexpr unsigned kNext = ((kFeatures | ~kMask) + 1) & kMask;  // counts through the mask's bits; 0 after the last
  if constexpr (kNext != 0)
    if (kFeatures != (features & kMask)) return WithFeatures<kMask, kNext>(features, std::forward<Call>(call));
  return call(std::integral_constant<unsigned, kFeatures>());
}

// Which lights are sampled for at a vertex.
enum class NextEvent : uint8_t {
  kNone,    // there are none to sample
  kUnseen,  // those that no path can meet: points, spots, distant ones, shapes of opacity 0
  kAll,
};

// Without next event estimation the others are left to the paths.
inline NextEvent SampledLights(const Scene& scene, NeeMode mode, uint32_t iteration) {
  if (!scene.has_lights()) return NextEvent::kNone;
  if (UsesNee(mode, iteration)) return NextEvent::kAll;
  return scene.needs().unseen_lights ? NextEvent::kUnseen : NextEvent::kNone;
}

struct PathSettings {
  int max_depth = 5;  // bounces; as pbrt's maxdepth
  NextEvent next_event = NextEvent::kAll;
  int roulette_start = 2;                       // first bounce that may be ended by roulette
  Roulette roulette = Roulette::kContribution;  // of guided paths; others look at the throughput
};

// Dimension pairs of a path: pixel, lens, then four a vertex: (roulette, mix), (lobe or technique, light), direction,
// position on the light.
inline constexpr uint32_t kFirstVertexPair = 2, kPairsPerVertex = 4;

struct PathCounters {
  uint64_t paths = 0, rays = 0, vertices = 0;
  uint64_t zero_pdf = 0;  // directions whose own technique gives them no density: dropped
};

// SceneT is Scene, or something that answers the same calls and watches them (bench/ray_replay.cpp).
template <unsigned kFeatures, class Guide, class SceneT = Scene>
class PathKernel {
 public:
  PathKernel(const SceneT& scene, const PathSettings& settings, const Guide& guide)
      : scene_(scene), settings_(settings), guide_(guide) {}

  // Radiance along the camera ray. `pixel` is what its pixel is expected to have, 0 if that is not known. With kRecord,
  // `vertices` receives the path (its storage is reused from path to path); of a guide that defers densities, the
  // vertices after the last light that was met have none.
  Rgb Trace(const CameraRay& camera_ray, float pixel, Sampler& sampler, PathCounters* counters,
            std::vector<PathVertex>* vertices) const;

 private:
  using Local = typename Guide::Local;
  // Density of the direction technique; bsdf_pdf is of smooth lobes.
  static float MixturePdf(const Local& local, float bsdf_pdf, float guide_pdf) {
    return local.bsdf_fraction * bsdf_pdf + (1 - local.bsdf_fraction) * guide_pdf;
  }
  struct DirectSample {
    Rgb radiance;
    uint8_t group = 0;  // of its light
  };
  DirectSample DirectLight(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo, const Local& local, double u_light,
                           Vec2 u, PathCounters* counters) const;
  // The next direction and its densities; weight = f cos / pdf, black where the path ends. With kDefers, `waiting` says
  // that pdf and guide_pdf are not known yet: until Weigh() it is f cos of a direction that the guide has drawn, f cos
  // / bsdf_pdf of one that the BSDF has.
  struct Scattering {
    Rgb weight;
    Vec3 wi;
    float pdf = 0, bsdf_pdf = 0, guide_pdf = 0, eta = 1, alpha = 1;
    bool delta = false, waiting = false, guided = false;
  };
  Scattering Scatter(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo, const Local& local, float u_technique,
                     Vec2 u, PathCounters* counters) const;
  void Weigh(const Local& local, Scattering* next, PathCounters* counters) const;

  static constexpr bool kDefers = Guide::kDefersDensities;
  // What a path has yet to be multiplied by. Not initialised: it has room for more than most paths need.
  struct Factor {
    Scattering next;
    Local at;
    float survivor = 1;
    uint32_t vertex = 0;  // with kRecord: which
  };
  struct Factors {
    static constexpr int kMost = 16;
    union {
      Factor factors[kMost];
    };
    int count = 0;
    Factors() {}
  };
  struct NoFactors {};

  const SceneT& scene_;
  const PathSettings settings_;
  const Guide& guide_;
};

// Light samples are taken at a share q of the vertices: the balance heuristic then sees a light density of q * pdf
// (Veach 1997, section 9.2.2: the expected number of samples is what counts). Of lights that no path can meet, they are
// all there is, and q was learned of others: q = 1.
template <unsigned kFeatures, class Guide, class SceneT>
inline auto PathKernel<kFeatures, Guide, SceneT>::DirectLight(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo,
                                                              const Local& local, double u_light, Vec2 u,
                                                              PathCounters* counters) const -> DirectSample {
  const bool all = settings_.next_event == NextEvent::kAll;
  float share = 1;
  if constexpr (Guide::kGuides) {
    if (all) share = local.nee_probability;
    if (!(u_light < share)) return {};
    u_light /= share;
  }
  const auto light =
      all ? scene_.SampleLight(si.p, u_light, u, local.lights) : scene_.SampleUnseenLight(si.p, u_light, u);
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
  const float light_pdf = light->pdf * share;
  float weight = 1;
  if (!light->delta) {
    float pdf = value.pdf;
    if constexpr (Guide::kGuides) {
      if (local.bsdf_fraction < 1) pdf = MixturePdf(local, pdf, guide_.Pdf(local, light->wi));
    }
    weight = light_pdf / (light_pdf + pdf);
  }
  return {value.f_cos * light->radiance * (weight / light_pdf), light->group};
}

template <unsigned kFeatures, class Guide, class SceneT>
inline auto PathKernel<kFeatures, Guide, SceneT>::Scatter(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo,
                                                          const Local& local, float u_technique, Vec2 u,
                                                          PathCounters* counters) const -> Scattering {
  constexpr bool kGuided = Guide::kGuides;
  Scattering next;
  if (!kGuided || u_technique < local.bsdf_fraction) {
    const float u_lobe = kGuided ? std::min(u_technique / local.bsdf_fraction, kOneMinusEpsilon) : u_technique;
    if (const auto sample = bsdf.Sample(wo, u_lobe, u)) {
      // Assigned one by one: made as a whole it is kept in memory, and renders take 3 % longer (GCC 12).
      next.wi = si.shading.ToWorld(sample->wi);
      next.delta = (kFeatures & kSpecular) != 0 && sample->delta;
      next.eta = sample->eta;
      next.alpha = sample->alpha;
      next.bsdf_pdf = sample->pdf;
      next.weight = sample->weight;
      next.pdf = next.bsdf_pdf;
      if constexpr (kGuided) {
        if (local.bsdf_fraction < 1) {
          if (next.delta) {
            next.pdf *= local.bsdf_fraction;
            next.weight *= 1 / local.bsdf_fraction;
          } else if constexpr (kDefers) {
            next.waiting = true;
          } else {
            next.guide_pdf = guide_.Pdf(local, next.wi);
            next.pdf = MixturePdf(local, next.bsdf_pdf, next.guide_pdf);
            next.weight *= next.bsdf_pdf / next.pdf;
          }
        }
      }
    }
  } else if constexpr (kDefers) {
    next.wi = guide_.Direction(local, u);
    const Vec3 local_wi = si.shading.ToLocal(next.wi);
    const BsdfValue value = bsdf.Evaluate(wo, local_wi);
    next.bsdf_pdf = value.pdf;
    next.eta = bsdf.EtaAcross(wo, local_wi);
    next.weight = value.f_cos;
    next.waiting = next.guided = true;
    if constexpr ((kFeatures & kRecord) != 0 && Guide::kUsesAlpha) next.alpha = bsdf.AlphaAt(wo, local_wi);
    // Roulette must know what the BSDF alone would weigh; where it would never go there, what the mixture does.
    if (!(next.bsdf_pdf > 0) && !IsBlack(next.weight)) Weigh(local, &next, counters);
  } else if constexpr (kGuided) {
    const GuidedSample sample =
        guide_.Sample(local, u, (u_technique - local.bsdf_fraction) / (1 - local.bsdf_fraction));
    const Vec3 local_wi = si.shading.ToLocal(sample.w);
    const BsdfValue value = bsdf.Evaluate(wo, local_wi);
    next.wi = sample.w;
    next.guide_pdf = sample.pdf;
    next.bsdf_pdf = value.pdf;
    next.eta = bsdf.EtaAcross(wo, local_wi);
    if constexpr ((kFeatures & kRecord) != 0) {
      if constexpr (Guide::kUsesAlpha) next.alpha = bsdf.AlphaAt(wo, local_wi);
    }
    next.pdf = MixturePdf(local, next.bsdf_pdf, next.guide_pdf);
    if (next.pdf > 0) {
      next.weight = value.f_cos * (1 / next.pdf);
    } else {
      ++counters->zero_pdf;
    }
  }
  return next;
}

template <unsigned kFeatures, class Guide, class SceneT>
inline void PathKernel<kFeatures, Guide, SceneT>::Weigh(const Local& local, Scattering* next,
                                                        PathCounters* counters) const {
  next->waiting = false;
  next->guide_pdf = guide_.Pdf(local, next->wi);
  next->pdf = MixturePdf(local, next->bsdf_pdf, next->guide_pdf);
  if (next->pdf > 0) {
    next->weight *= (next->guided ? 1 : next->bsdf_pdf) / next->pdf;
  } else {
    next->weight = {};
    ++counters->zero_pdf;
  }
}

template <unsigned kFeatures, class Guide, class SceneT>
Rgb PathKernel<kFeatures, Guide, SceneT>::Trace(const CameraRay& camera_ray, float pixel, Sampler& sampler,
                                                PathCounters* counters, std::vector<PathVertex>* vertices) const {
  constexpr bool kGuided = Guide::kGuides, kRecording = (kFeatures & kRecord) != 0;
  constexpr bool kHasTextures = (kFeatures & kTextures) != 0, kHasSpecular = (kFeatures & kSpecular) != 0;
  Ray ray{camera_ray.origin, camera_ray.direction, kInfinity};
  Rgb radiance, beta(1);
  PathRoulette roulette;
  // With a guide it expects what the pixel may; else, once a vertex is met that the guide knows, what that reflects,
  // from its fluence and albedo.
  const bool by_contribution = kGuided && settings_.roulette != Roulette::kThroughput;
  if (by_contribution && settings_.roulette == Roulette::kPixel) roulette.expected = pixel;
  // of the direction that led here; 0: a delta lobe or the camera, whose emission counts in full
  float previous_pdf = 0;
  float previous_nee = 1;  // the share of light samples at the vertex it came from, and the lights that they chose
  LightGroupWeights previous_lights;
  Vec3 previous_p;
  const bool weighted = settings_.next_event == NextEvent::kAll;  // emission, against light samples
  if constexpr (kRecording) vertices->clear();
  ++counters->paths;
  // Before beta and previous_pdf matter, for light that is met: of what is left of a path that meets none, no density
  // is worked out at all.
  std::conditional_t<kDefers, Factors, NoFactors> waiting;
  const auto settle = [&] {
    if constexpr (kDefers) {
      for (int i = 0; i < waiting.count; ++i) {
        Factor& factor = waiting.factors[i];
        if (factor.next.waiting) Weigh(factor.at, &factor.next, counters);
        if constexpr (kRecording) {
          PathVertex& vertex = (*vertices)[factor.vertex];
          vertex.beta = beta;
          vertex.weight = factor.next.weight;
          vertex.pdf = factor.next.pdf;
          vertex.guide_pdf = factor.next.guide_pdf;
        }
        beta *= factor.next.weight;
        beta *= factor.survivor;
        previous_pdf = factor.next.delta ? 0 : factor.next.pdf;
      }
      waiting.count = 0;
    }
  };

  for (int depth = 0;;) {
    ++counters->rays;
    Hit hit;
    if (!scene_.Intersect(ray, &hit)) {
      if constexpr ((kFeatures & kEnvironment) != 0) {
        const EnvironmentSample environment = scene_.Environment(ray.direction);
        if (!IsBlack(environment.radiance)) settle();
        float weight = 1;
        if (previous_pdf > 0 && weighted) {
          float light_pdf = previous_nee * environment.pdf;
          if constexpr (kGuided) light_pdf *= previous_lights.empty() ? 1 : scene_.EnvironmentRatio(previous_lights);
          weight = previous_pdf / (previous_pdf + light_pdf);
        }
        radiance += beta * (environment.radiance * weight);
        if constexpr (kRecording)
          vertices->push_back({.emitted = environment.radiance, .emission_weight = weight, .distance = kInfinity});
      }
      break;
    }
    ++counters->vertices;
    const SurfaceInteraction si = scene_.Interaction(hit);

    // Light that the surface itself gives.
    Rgb emitted;
    float emission_weight = 1;
    if (si.light >= 0) {
      emitted = scene_.Emitted(si, -ray.direction);
      if (!IsBlack(emitted)) settle();
      if (previous_pdf > 0 && weighted && !IsBlack(emitted)) {
        float light_pdf = previous_nee * scene_.LightPdf(previous_p, si);
        if constexpr (kGuided) light_pdf *= previous_lights.empty() ? 1 : scene_.LightRatio(previous_lights, si.light);
        emission_weight = previous_pdf / (previous_pdf + light_pdf);
      }
      radiance += beta * (emitted * emission_weight);
    }
    if (depth == settings_.max_depth) {
      if constexpr (kRecording)
        vertices->push_back({.emitted = emitted, .emission_weight = emission_weight, .distance = hit.t});
      break;
    }
    sampler.StartAt(kFirstVertexPair + static_cast<uint32_t>(depth) * kPairsPerVertex);
    const Vec2 u_mix = sampler.Next2D(), u_choice = sampler.Next2D(), u_direction = sampler.Next2D();
    const Bsdf& bsdf = [&]() -> decltype(auto) {
      if constexpr (kHasTextures) {
        return scene_.BsdfAt(si, u_mix.y);
      } else {
        return scene_.ReadyBsdf(si);
      }
    }();

    // Light that reaches it straight from a source.
    const Vec3 wo = si.shading.ToLocal(-ray.direction);
    const bool smooth = !kHasSpecular || bsdf.HasSmoothLobes();
    const Local at = smooth ? guide_.At(si, bsdf, wo) : Local{};
    DirectSample direct;
    if (smooth && settings_.next_event != NextEvent::kNone)
      direct = DirectLight(si, bsdf, wo, at, sampler.Refine(u_choice.y), sampler.Next2D(), counters);
    if (!IsBlack(direct.radiance)) settle();
    radiance += beta * direct.radiance;

    const Scattering next = Scatter(si, bsdf, wo, at, u_choice.x, u_direction, counters);
    const bool ended = IsBlack(next.weight);
    if constexpr (kRecording) {
      vertices->push_back({.emitted = emitted,
                           .emission_weight = emission_weight,
                           .direct = direct.radiance,
                           .light_group = direct.group,
                           .weight = next.weight,
                           .beta = beta,
                           .distance = hit.t,
                           .alpha = next.alpha,
                           .p = si.p,
                           .wi = next.wi,
                           .pdf = next.pdf,
                           .bsdf_pdf = next.bsdf_pdf,
                           .guide_pdf = next.guide_pdf,
                           .leaf = at.leaf,
                           .smooth = smooth,
                           .recorded = smooth && !next.delta && !ended});
    }
    if (ended) break;
    if constexpr (kGuided) {
      if (by_contribution && roulette.expected == 0 && at.bsdf_fraction < 1 && guide_.Fluence(at) > 0)
        roulette.expected = Luminance(beta * bsdf.Albedo(wo)) * guide_.Fluence(at) * (0.5f * kInvPi);
    }
    if constexpr (kDefers) {
      if (waiting.count == Factors::kMost) settle();
      waiting.factors[waiting.count++] = {.next = next, .at = at};
      if constexpr (kRecording) waiting.factors[waiting.count - 1].vertex = static_cast<uint32_t>(vertices->size() - 1);
    } else {
      beta *= next.weight;
    }
    // Refraction scales radiance by the square of the relative index; survival must not depend on that (as pbrt).
    const float eta_squared = next.eta * next.eta;
    roulette.throughput *= next.weight * eta_squared;
    if constexpr (kDefers) {  // such guides know no contribution
      if (next.delta) {
        roulette.throughput *= at.bsdf_fraction;
      } else if (next.waiting) {
        if (next.guided) roulette.throughput *= 1 / next.bsdf_pdf;
      } else if (next.bsdf_pdf > 0) {
        roulette.throughput *= next.pdf / next.bsdf_pdf;
      }
    } else if constexpr (kGuided) {
      if (next.delta) {
        roulette.throughput *= at.bsdf_fraction;
        roulette.contribution *= Luminance(next.weight) * eta_squared;
      } else {
        if (next.bsdf_pdf > 0) roulette.throughput *= next.pdf / next.bsdf_pdf;
        const bool known = by_contribution && next.guide_pdf > 0 && guide_.Fluence(at) > 0;
        roulette.contribution = known ? Luminance(beta) * guide_.Radiance(at, next.wi, next.guide_pdf) : 0;
      }
    }
    ++depth;

    if (depth >= settings_.roulette_start) {
      const float survivor = roulette.Survive(u_mix.x);
      if constexpr (kRecording) vertices->back().roulette = survivor;
      if (survivor == 0) break;
      if constexpr (kDefers) {
        waiting.factors[waiting.count - 1].survivor = survivor;
      } else {
        beta *= survivor;
      }
    }
    if constexpr (!kDefers) previous_pdf = next.delta ? 0 : next.pdf;
    previous_nee = at.nee_probability;
    previous_lights = at.lights;
    previous_p = si.p;
    ray = {Scene::OffsetOrigin(si, next.wi), next.wi, kInfinity};
  }
  return radiance;
}

}  // namespace lodestar
