// What grid guiding is worth, rule by rule: error at equal samples, time per sample and wasted directions, each
// relative to another method (path tracing), on one thread, in user CPU time, variants interleaved.
//
//   build/release/bin/grid_bench SCENE.pbrt WIDTH HEIGHT SPP SEEDS REFERENCE_SPP VARIANT...
//
// A variant is a method and its options: path:nee=never, grid:learn=sarsa,sampling=rejection. The first is what the
// others are related to. Columns:
//   MAE       mean absolute error of the image against a path-traced one of REFERENCE_SPP, over the first's
//   spread    standard error of that ratio over the seeds
//   relMSE    trimmed, over the first's
//   time      of a whole run, learning included, over the first's: medians
//   rays      over the first's: guided paths are longer
//   gain      of efficiency: 1 / (relMSE * time)
//   invalid   directions, by any technique, that lie below the surface or carry nothing for another reason, in per cent
//   mean      of the image over the reference's: 1 but for noise, and for the bias of the -memo samplings
//   +-        its standard error, the reference's not counted
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/film/error_metrics.h"
#include "core/learning/loop.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/grid_guide.h"
#include "core/tracing/local_executor.h"
#include "core/tracing/path_kernel.h"
#include "core/tracing/tracer.h"

namespace lodestar {
namespace {

struct Variant {
  std::string name;
  JobSpec job;
  std::vector<double> mae, relmse, seconds, mean;
  std::shared_ptr<const State> state;  // of the last seed
  double rays = 0;
};

double CpuSeconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Variant MakeVariant(const std::string& text, const JobSpec& common) {
  Variant v;
  v.name = text;
  v.job = common;
  const size_t colon = text.find(':');
  v.job.method = text.substr(0, colon);
  for (size_t at = colon; at != std::string::npos;) {
    const size_t end = text.find(',', ++at), equals = text.find('=', at);
    v.job.options[text.substr(at, equals - at)] =
        text.substr(equals + 1, end == std::string::npos ? end : end - equals - 1);
    at = end;
  }
  return v;
}

double Mean(const Image& image) {
  double sum = 0;
  for (const Rgb pixel : image.pixels) sum += Luminance(pixel);
  return sum / static_cast<double>(image.size());
}

Image RunLoop(const CompiledJob& compiled, const JobSpec& job, Variant* v = nullptr) {
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), 1);
  const StopToken stop;
  loop.Run(executor, stop, {});
  if (v != nullptr) {
    v->state = loop.state();
    v->rays = static_cast<double>(loop.Report().rays);
  }
  return loop.Develop();
}

// The grid's guide, watched: what becomes of the directions it draws.
class WatchedGuide : public GridGuide {
 public:
  struct Local : GridGuide::Local {
    Bsdf bsdf = Bsdf::None();
    Frame shading;
    Vec3 wo;
  };
  using GridGuide::GridGuide;
  Local At(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) const {
    ++vertices;
    return {GridGuide::At(si, bsdf, wo), bsdf, si.shading, wo};
  }
  GuidedSample Sample(const Local& local, Vec2 u, float u_more) const {
    const GuidedSample sample = GridGuide::Sample(local, u, u_more);
    invalid += IsBlack(local.bsdf.Evaluate(local.wo, local.shading.ToLocal(sample.w)).f_cos) &&
               !IsBlack(local.bsdf.Albedo(local.wo));
    return sample;
  }
  mutable uint64_t vertices = 0, invalid = 0;
};

double InvalidPercent(const CompiledJob& compiled, const Variant& v) {
  const auto grid = std::dynamic_pointer_cast<const GridState>(v.state);
  if (!grid) return 0;
  const GridMethod method(v.job, compiled.survey);
  const WatchedGuide guide(grid->grid(), method.options());
  const Scene& scene = *compiled.scene;
  PathSettings settings;
  settings.max_depth = scene.max_depth();
  settings.next_event = method.options().nee == NeeMode::kAlways && scene.has_lights();
  const PathKernel<kEnvironment, WatchedGuide> kernel(scene, settings, guide);
  PathCounters counters;
  for (int y = 0; y < scene.resolution_y(); ++y)
    for (int x = 0; x < scene.resolution_x(); ++x) {
      Sampler sampler(99, static_cast<uint32_t>(x), static_cast<uint32_t>(y), 0);
      const Vec2 u = sampler.Next2D();
      kernel.Trace(scene.camera().Generate({static_cast<float>(x) + u.x, static_cast<float>(y) + u.y}, {0.5f, 0.5f}), 0,
                   sampler, &counters, nullptr);
    }
  return 100.0 * static_cast<double>(guide.invalid) / static_cast<double>(std::max<uint64_t>(1, guide.vertices));
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void Main(int argc, char** argv) {
  JobSpec common;
  common.resolution_x = static_cast<uint32_t>(std::atoi(argv[2]));
  common.resolution_y = static_cast<uint32_t>(std::atoi(argv[3]));
  common.filter = "box";
  common.lenient = true;
  common.budget.spp = static_cast<uint64_t>(std::atoi(argv[4]));
  const int seeds = std::max(1, std::atoi(argv[5]));
  std::vector<Variant> variants;
  for (int i = 7; i < argc; ++i) variants.push_back(MakeVariant(argv[i], common));
  const CompiledJob compiled = CompileJob(ParsePbrtFile(argv[1]), common);

  JobSpec job = MakeVariant("path", common).job;
  job.seed = 77777;
  job.budget.spp = static_cast<uint64_t>(std::atoi(argv[6]));
  const Image reference = RunLoop(compiled, job);
  for (int seed = 0; seed < seeds; ++seed)
    for (Variant& v : variants) {
      v.job.seed = static_cast<uint64_t>(seed);
      const double start = CpuSeconds();
      const Image image = RunLoop(compiled, v.job, &v);
      v.seconds.push_back(CpuSeconds() - start);
      const ErrorMetrics error = Compare(image, reference);
      v.mae.push_back(error.mae);
      v.relmse.push_back(error.relmse_trimmed);
      v.mean.push_back(Mean(image) / Mean(reference));
    }
  std::printf("%s, %ux%u, %s spp, %d seeds\n%7s %7s %7s %7s %7s %7s %7s %8s %8s\n", argv[1], common.resolution_x,
              common.resolution_y, argv[4], seeds, "MAE", "spread", "relMSE", "time", "rays", "gain", "invalid", "mean",
              "+-");
  for (Variant& v : variants) {
    double mae = 0, relmse = 0, base_mae = 0, base_relmse = 0, mean = 0, square = 0;
    for (size_t s = 0; s < v.mae.size(); ++s) {
      mae += v.mae[s], relmse += v.relmse[s], mean += v.mean[s] / seeds;
      base_mae += variants[0].mae[s], base_relmse += variants[0].relmse[s];
    }
    double mean_square = 0;
    for (const double m : v.mean) mean_square += Sqr(static_cast<float>(m - mean));
    for (size_t s = 0; s < v.mae.size(); ++s)
      square += Sqr(static_cast<float>(v.mae[s] / variants[0].mae[s] - mae / base_mae));
    const double time = Median(v.seconds) / Median(variants[0].seconds);
    std::printf("%7.3f %7.3f %7.3f %7.3f %7.3f %7.3f %7.3f %8.5f %8.5f  %s\n", mae / base_mae,
                std::sqrt(square) / seeds, relmse / base_relmse, time, v.rays / variants[0].rays,
                base_relmse / (relmse * time), InvalidPercent(compiled, v), mean, std::sqrt(mean_square) / seeds,
                v.name.c_str());
  }
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  if (argc < 8) {
    std::fprintf(stderr, "usage: grid_bench SCENE.pbrt WIDTH HEIGHT SPP SEEDS REFERENCE_SPP VARIANT...\n");
    return 1;
  }
  try {
    lodestar::Main(argc, argv);
  } catch (const lodestar::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
