// What the compiled scene costs a path vertex: each query on the hits of real paths in a real scene.
//   LODESTAR_SCENE=path/to/scene.pbrt scene_bench        (default: ../shared/scenes/veach-ajar)
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <memory>
#include <vector>

#include "core/math/sampler.h"
#include "core/scene/pbrt_parser.h"
#include "core/scene/scene.h"

namespace lodestar {
namespace {

// Rays, hits and light samples of diffuse-like paths of up to eight vertices: as incoherent as a path tracer's.
struct Recording {
  std::shared_ptr<const Scene> scene;
  std::vector<Ray> rays, shadow_rays;
  std::vector<Hit> hits;
  std::vector<SurfaceInteraction> surfaces;
};

const Recording& Record() {
  static const Recording recording = [] {
    Recording r;
    const char* path = std::getenv("LODESTAR_SCENE");
    r.scene = Scene::Compile(ParsePbrtFile(path ? path : "../shared/scenes/veach-ajar/veach-ajar.pbrt"));
    const Scene& scene = *r.scene;
    for (uint32_t i = 0; r.rays.size() < 200000; ++i) {
      Sampler sampler(1, i, 0, 0);
      const Vec2 film = sampler.Next2D();
      const CameraRay camera = scene.camera().Generate(
          {film.x * float(scene.resolution_x()), film.y * float(scene.resolution_y())}, {0.5f, 0.5f});
      Ray ray{camera.origin, camera.direction, kInfinity};
      for (int depth = 0; depth < 8; ++depth) {
        r.rays.push_back(ray);
        Hit hit;
        if (!scene.Intersect(ray, &hit)) break;
        const SurfaceInteraction si = scene.Interaction(hit);
        r.hits.push_back(hit);
        r.surfaces.push_back(si);
        const Vec2 pick = sampler.Next2D();
        if (const auto light = scene.SampleLight(si.p, pick.x, sampler.Next2D())) {
          Ray shadow{Scene::OffsetOrigin(si, light->wi), light->wi, kInfinity};
          if (!light->infinite) {
            shadow.t_max = Length(light->target - shadow.origin);
            shadow.direction = (light->target - shadow.origin) / shadow.t_max;
          }
          r.shadow_rays.push_back(shadow);
        }
        const Bsdf bsdf = scene.BsdfAt(si, pick.y);
        const Vec2 u = sampler.Next2D();
        const auto sample = bsdf.Sample(si.shading.ToLocal(-ray.direction), sampler.Next2D().x, u);
        if (!sample) break;
        const Vec3 w = si.shading.ToWorld(sample->wi);
        ray = {Scene::OffsetOrigin(si, w), w, kInfinity};
      }
    }
    return r;
  }();
  return recording;
}

template <class Work>
void Run(benchmark::State& state, size_t count, Work work) {
  size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(work(i));
    if (++i == count) i = 0;
  }
}

void BM_Intersect(benchmark::State& state) {
  const Recording& r = Record();
  Run(state, r.rays.size(), [&](size_t i) {
    Hit hit;
    return r.scene->Intersect(r.rays[i], &hit);
  });
}
void BM_Unoccluded(benchmark::State& state) {
  const Recording& r = Record();
  Run(state, r.shadow_rays.size(), [&](size_t i) { return r.scene->Unoccluded(r.shadow_rays[i]); });
}
void BM_Interaction(benchmark::State& state) {
  const Recording& r = Record();
  Run(state, r.hits.size(), [&](size_t i) { return r.scene->Interaction(r.hits[i]); });
}
void BM_BsdfAt(benchmark::State& state) {
  const Recording& r = Record();
  Run(state, r.surfaces.size(), [&](size_t i) { return r.scene->BsdfAt(r.surfaces[i], 0.5f); });
}
void BM_SampleLight(benchmark::State& state) {
  const Recording& r = Record();
  Run(state, r.surfaces.size(), [&](size_t i) {
    const uint64_t bits = Mix64(i);
    return r.scene->SampleLight(r.surfaces[i].p, Sampler::ToUnit(uint32_t(bits)),
                                {Sampler::ToUnit(uint32_t(bits >> 32)), Sampler::ToUnit(uint32_t(bits >> 20))});
  });
}
void BM_Environment(benchmark::State& state) {
  const Recording& r = Record();
  Run(state, r.rays.size(), [&](size_t i) { return r.scene->Environment(r.rays[i].direction); });
}

BENCHMARK(BM_Intersect);
BENCHMARK(BM_Unoccluded);
BENCHMARK(BM_Interaction);
BENCHMARK(BM_BsdfAt);
BENCHMARK(BM_SampleLight);
BENCHMARK(BM_Environment);

}  // namespace
}  // namespace lodestar

BENCHMARK_MAIN();
