#include "core/tracing/feature_pass.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/threads.h"
#include "core/tracing/path_tracer.h"
#include "core/tracing/visit_guide.h"

namespace lodestar {
namespace {

// The next surface along a ray, as the path's vertex `depth`.
std::optional<SurfaceHit> NextSurface(const Scene& scene, const Ray& ray, uint32_t depth, Sampler& sampler) {
  sampler.StartAt(kFirstVertexPair + depth * kPairsPerVertex);
  Hit hit;
  if (!scene.Intersect(ray, &hit)) return std::nullopt;
  SurfaceHit found;
  found.si = scene.Interaction(hit);
  found.bsdf = scene.BsdfAt(found.si, sampler.Next2D().y);
  found.wo = found.si.shading.ToLocal(-ray.direction);
  found.distance = hit.t;
  return found;
}

// From a first surface on.
std::optional<SurfaceHit> ThroughMirrors(const Scene& scene, std::optional<SurfaceHit> at, Sampler& sampler) {
  for (uint32_t depth = 0; at && !at->bsdf.HasSmoothLobes(); ++depth) {
    if (depth >= static_cast<uint32_t>(scene.max_depth())) return std::nullopt;
    // The kernel's numbers for this vertex: (roulette, mix), (technique, light), direction.
    sampler.StartAt(kFirstVertexPair + depth * kPairsPerVertex + 1);
    const float u_lobe = sampler.Next2D().x;
    const auto sample = at->bsdf.Sample(at->wo, u_lobe, sampler.Next2D());
    if (!sample) return std::nullopt;
    const Vec3 wi = at->si.shading.ToWorld(sample->wi);
    at = NextSurface(scene, {Scene::OffsetOrigin(at->si, wi), wi, kInfinity}, depth + 1, sampler);
  }
  return at;
}

void RenderRow(const Scene& scene, const PixelFilter& filter, uint64_t seed, const SharesAt& shares, uint32_t y,
               Features* out) {
  for (uint32_t x = 0; x < out->width; ++x) {
    Rgb albedo;
    Vec3 normal;
    float depth = 0, fraction = 0, nee = 0;
    int hits = 0, smooth_hits = 0;
    for (uint32_t pass = 0; pass < kFeatureSamples; ++pass) {
      Sampler sampler(seed, x, y, pass);
      const Vec2 offset = filter.Sample(sampler.Next2D()).offset;
      const Vec2 film{static_cast<float>(x) + 0.5f + offset.x, static_cast<float>(y) + 0.5f + offset.y};
      const CameraRay ray = scene.camera().Generate(film, scene.camera().has_lens() ? sampler.Next2D() : Vec2{});
      const auto first = FirstSurface(scene, ray, sampler);
      if (!first) continue;
      ++hits;
      albedo += first->bsdf.Albedo(first->wo);
      normal += first->wo.z < 0 ? -first->si.shading.n : first->si.shading.n;
      depth += first->distance;
      const auto smooth = ThroughMirrors(scene, first, sampler);
      if (!smooth) continue;
      ++smooth_hits;
      const TechniqueShares at = shares(*smooth);
      fraction += at.bsdf_fraction;
      nee += at.nee_probability;
    }
    const size_t i = size_t{y} * out->width + x;
    out->albedo[i] = albedo * (1.0f / kFeatureSamples);
    out->normal[i] = normal * (1.0f / kFeatureSamples);
    out->depth[i] = hits > 0 ? depth / static_cast<float>(hits) : kInfinity;
    if (smooth_hits == 0) continue;
    out->bsdf_fraction[i] = fraction / static_cast<float>(smooth_hits);
    out->nee[i] = nee / static_cast<float>(smooth_hits);
  }
}

}  // namespace

std::optional<SurfaceHit> FirstSurface(const Scene& scene, const CameraRay& ray, Sampler& sampler) {
  return NextSurface(scene, {ray.origin, ray.direction, kInfinity}, 0, sampler);
}

std::optional<SurfaceHit> FirstSmoothSurface(const Scene& scene, const CameraRay& ray, Sampler& sampler) {
  return ThroughMirrors(scene, FirstSurface(scene, ray, sampler), sampler);
}

SharesAt SharesOf(const Scene& scene, const Method& method, const std::shared_ptr<const State>& state) {
  return VisitGuide(scene, method, state, [](auto guide, const PathSettings& settings) -> SharesAt {
    return [guide = std::move(guide), next_event = settings.next_event](const SurfaceHit& hit) -> TechniqueShares {
      const auto local = guide.At(hit.si, hit.bsdf, hit.wo);
      const float shares[] = {0, 1, local.nee_probability};  // by NextEvent
      return {local.bsdf_fraction, shares[static_cast<size_t>(next_event)]};
    };
  });
}

Features RenderFeatures(const Scene& scene, uint64_t seed, const SharesAt& shares, int threads) {
  Features out;
  out.width = static_cast<uint32_t>(scene.resolution_x());
  out.height = static_cast<uint32_t>(scene.resolution_y());
  const size_t pixels = size_t{out.width} * out.height;
  out.albedo.resize(pixels);
  out.normal.resize(pixels);
  out.depth.resize(pixels);
  out.bsdf_fraction.resize(pixels);
  out.nee.resize(pixels);
  const PixelFilter filter = MakePixelFilter(scene);
  tbb::task_arena arena(threads > 0 ? threads : UsableThreads());
  arena.execute([&] { ParallelFor(out.height, [&](uint32_t y) { RenderRow(scene, filter, seed, shares, y, &out); }); });
  return out;
}

}  // namespace lodestar
