// How much of a render is Embree? Traces a scene's paths on one thread, then traces exactly the same rays again with
// nothing around them, and prints the ratio, medians of interleaved repetitions.
//
//   build/release/bin/ray_replay SCENE.pbrt [WIDTH HEIGHT PASSES REPETITIONS]
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bench/study_main.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/path_kernel.h"
#include "core/tracing/tracer.h"

namespace lodestar {
namespace {

struct LoggedRay {
  Ray ray;
  bool shadow;
};

// Answers as the scene does and keeps the rays.
class RecordingScene {
 public:
  RecordingScene(const Scene& scene, std::vector<LoggedRay>* log) : scene_(scene), log_(log) {}
  bool Intersect(const Ray& ray, Hit* hit) const {
    log_->push_back({ray, false});
    return scene_.Intersect(ray, hit);
  }
  bool Unoccluded(const Ray& ray) const {
    log_->push_back({ray, true});
    return scene_.Unoccluded(ray);
  }
  SurfaceInteraction Interaction(const Hit& hit) const { return scene_.Interaction(hit); }
  Bsdf BsdfAt(const SurfaceInteraction& si, float u) const { return scene_.BsdfAt(si, u); }
  const Bsdf& ReadyBsdf(const SurfaceInteraction& si) const { return scene_.ReadyBsdf(si); }
  std::optional<LightSample> SampleUnseenLight(Vec3 p, double pick, Vec2 u) const {
    return scene_.SampleUnseenLight(p, pick, u);
  }
  std::optional<LightSample> SampleLight(Vec3 p, double pick, Vec2 u, LightGroupWeights weights) const {
    return scene_.SampleLight(p, pick, u, weights);
  }
  Rgb Emitted(const SurfaceInteraction& si, Vec3 wo) const { return scene_.Emitted(si, wo); }
  float LightPdf(Vec3 from, const SurfaceInteraction& si) const { return scene_.LightPdf(from, si); }
  EnvironmentSample Environment(Vec3 wi) const { return scene_.Environment(wi); }

 private:
  const Scene& scene_;
  std::vector<LoggedRay>* log_;
};

// Every pixel sample of the image, in the order a render takes them within a tile.
template <unsigned kFeatures, class SceneT>
double TraceWith(const SceneT& view, const Scene& scene, int passes, PathCounters* counters) {
  PathSettings settings;
  settings.max_depth = scene.max_depth();
  const NoGuide guide;
  const PathKernel<kFeatures, NoGuide, SceneT> kernel(view, settings, guide);
  double sum = 0;
  const TileGrid grid(static_cast<uint32_t>(scene.resolution_x()), static_cast<uint32_t>(scene.resolution_y()));
  for (uint32_t unit = 0; unit < grid.tile_count(); ++unit) {
    const TileRect rect = grid.Rect(unit);
    for (uint32_t y = rect.y0; y < rect.y1; ++y)
      for (uint32_t x = rect.x0; x < rect.x1; ++x)
        for (int pass = 0; pass < passes; ++pass) {
          Sampler sampler(1, x, y, static_cast<uint32_t>(pass));
          const Vec2 u = sampler.Next2D();
          sum += Luminance(
              kernel.Trace(scene.camera().Generate({static_cast<float>(x) + u.x, static_cast<float>(y) + u.y}, {}), 0,
                           sampler, counters, nullptr));
        }
  }
  return sum;
}

template <class SceneT>
double TraceAll(const SceneT& view, const Scene& scene, int passes, PathCounters* counters) {
  return WithFeatures<kEnvironment | kTextures | kSpecular>(KernelFeatures(scene.needs()), [&](auto features) {
    return TraceWith<features.value>(view, scene, passes, counters);
  });
}

// Of the processor, not of the wall: a busy machine disturbs it less.
double ThreadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

int Run(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: ray_replay SCENE.pbrt [WIDTH HEIGHT PASSES REPETITIONS]\n");
    return 2;
  }
  JobSpec job;
  job.resolution_x = argc > 3 ? static_cast<uint32_t>(std::atoi(argv[2])) : 320;
  job.resolution_y = argc > 3 ? static_cast<uint32_t>(std::atoi(argv[3])) : 180;
  const int passes = argc > 4 ? std::atoi(argv[4]) : 4, repetitions = argc > 5 ? std::atoi(argv[5]) : 5;
  const auto scene = CompileJob(ParsePbrtFile(argv[1]), job).scene;

  std::vector<LoggedRay> log;
  PathCounters counters;
  TraceAll(RecordingScene(*scene, &log), *scene, passes, &counters);
  const auto seconds = [](auto&& work) {
    const double start = ThreadSeconds();
    work();
    return ThreadSeconds() - start;
  };
  std::vector<double> render, replay, ratio;
  uint64_t hits = 0;
  double sum = 0;
  for (int i = 0; i < repetitions; ++i) {
    PathCounters ignored;
    render.push_back(seconds([&] { sum += TraceAll(*scene, *scene, passes, &ignored); }));
    replay.push_back(seconds([&] {
      Hit hit;
      for (const LoggedRay& logged : log)
        hits += logged.shadow ? scene->Unoccluded(logged.ray) : scene->Intersect(logged.ray, &hit);
    }));
    ratio.push_back(render.back() / replay.back());
  }
  const double seconds_render = Median(render);
  std::printf("%s %ux%u, %d passes, %zu rays, %llu vertices (checks %g, %llu)\n", argv[1], job.resolution_x,
              job.resolution_y, passes, log.size(), static_cast<unsigned long long>(counters.vertices), sum,
              static_cast<unsigned long long>(hits));
  std::printf("render %.3f s, rays alone %.3f s, ratio %.2f (%.2f .. %.2f)\n", seconds_render, Median(replay),
              Median(ratio), *std::min_element(ratio.begin(), ratio.end()),
              *std::max_element(ratio.begin(), ratio.end()));
  std::printf("%.2f million vertices/s, %.2f million rays/s, %.3f million camera paths/s, one core\n",
              static_cast<double>(counters.vertices) / seconds_render * 1e-6,
              static_cast<double>(log.size()) / seconds_render * 1e-6,
              static_cast<double>(counters.paths) / seconds_render * 1e-6);
  return 0;
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  return lodestar::StudyMain(lodestar::Run, argc, argv);
}
