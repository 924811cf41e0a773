// What a guiding method's settings are worth, as tables in Markdown: error at equal samples, time per sample, and where
// directions go, each relative to another variant, on one thread, in CPU time, variants interleaved.
//
//   build/release/bin/guide_study SCENE.pbrt WIDTH HEIGHT DEPTH SPP SEEDS REFERENCE VARIANT...
//
// DEPTH 0 is the scene's. REFERENCE is an image of that size, or the samples per pixel of a path-traced one of another
// seed. A variant is a method and its options: path:nee=never, grid:learn=sarsa,sampling=rejection; one more,
// training-iterations=N, ends training there. The first is what the others are related to. Columns:
//   MSE, MAE, relMSE  of the image (relMSE trimmed) over the first's, means over the seeds
//   +-        standard errors over the seeds, of the ratios and of the shares
//   time      of a whole run, learning included, over the first's: medians
//   rays      over the first's: guided paths are longer
//   gain      in efficiency, 1 / (MSE * time); "rel": by relMSE
//   hits      of a guided method's directions drawn at surfaces that are not mirrors, those that meet something that
//             shines, in per cent, under the state that the run ended with (of auto: the chosen method's)
//   invalid   those that lie below the surface or carry nothing for another reason, in per cent
//   mean      of the image over the reference's: 1 but for noise, which its standard error leaves out of the
//             reference, and for the bias of the grid's -memo samplings
//   nodes     of the octrees or directional trees that a run ended with; of the last seed
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "bench/study_main.h"
#include "core/film/error_metrics.h"
#include "core/image/image.h"
#include "core/learning/loop.h"
#include "core/learning/path_tracing.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "core/tracing/tracer.h"
#include "core/tracing/visit_guide.h"

namespace lodestar {
namespace {

struct Variant {
  std::string name;
  JobSpec job;
  std::vector<double> mse, mae, relmse, seconds, mean, hits, invalid;
  std::shared_ptr<const State> state;  // of the last seed
  double rays = 0;
  size_t nodes = 0;
};

Variant MakeVariant(const std::string& text, const JobSpec& common) {
  Variant v;
  v.name = text;
  v.job = common;
  const size_t colon = text.find(':');
  v.job.method = text.substr(0, colon);
  for (size_t at = colon; at != std::string::npos;) {
    const size_t end = text.find(',', ++at), equals = text.find('=', at);
    const std::string option = text.substr(at, equals - at),
                      value = text.substr(equals + 1, end == std::string::npos ? end : end - equals - 1);
    if (option == "training-iterations") {
      v.job.training_iterations = std::atoi(value.c_str());
    } else {
      v.job.options[option] = value;
    }
    at = end;
  }
  return v;
}

double Mean(const Image& image) {
  double sum = 0;
  for (const Rgb pixel : image.pixels) sum += Luminance(pixel);
  return sum / static_cast<double>(image.size());
}

size_t NodeCount(const State* state) {
  size_t nodes = 0;
  if (const auto* focal = dynamic_cast<const FocalState*>(state)) {
    for (const FocalOctree& octree : focal->field().octrees()) nodes += octree.node_count();
  } else if (const auto* tree = dynamic_cast<const SdTreeState*>(state)) {
    nodes = tree->tree().node_count();
  } else if (const auto* mixed = dynamic_cast<const MixedState*>(state)) {
    nodes = NodeCount(mixed->tree().get()) + NodeCount(mixed->focal().get());
  }
  return nodes;
}

Image RunLoop(const CompiledJob& compiled, const JobSpec& job, Variant* v = nullptr) {
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), 1);
  const StopToken stop;
  loop.Run(executor, stop, {});
  if (v != nullptr) {
    v->state = loop.state();
    v->nodes = NodeCount(loop.method().ActiveUnder(loop.state()).state.get());
    v->rays = static_cast<double>(loop.Report().rays);
  }
  return loop.Develop();
}

// What becomes of the directions that are drawn under a variant's last state: one path a pixel.
struct Directions {
  uint64_t drawn = 0, hits = 0, invalid = 0;
  double Percent(uint64_t count) const { return 100.0 * static_cast<double>(count) / std::max<double>(1, drawn); }
};

template <class Guide>
Directions Watch(const Scene& scene, NextEvent next_event, const Guide& guide) {
  PathSettings settings;
  settings.max_depth = scene.max_depth();
  settings.next_event = next_event;
  const PathKernel<kRecord | kEnvironment | kTextures | kSpecular, Guide> kernel(scene, settings, guide);
  PathCounters counters;
  std::vector<PathVertex> vertices;
  Directions directions;
  for (int y = 0; y < scene.resolution_y(); ++y)
    for (int x = 0; x < scene.resolution_x(); ++x) {
      Sampler sampler(99, static_cast<uint32_t>(x), static_cast<uint32_t>(y), 0);
      const Vec2 u = sampler.Next2D();
      kernel.Trace(scene.camera().Generate({static_cast<float>(x) + u.x, static_cast<float>(y) + u.y}, {0.5f, 0.5f}), 0,
                   sampler, &counters, &vertices);
      for (size_t i = 0; i < vertices.size(); ++i) {
        const PathVertex& vertex = vertices[i];
        if (vertex.recorded) {
          ++directions.drawn;
          directions.hits += i + 1 < vertices.size() && !IsBlack(vertices[i + 1].emitted);
        } else if (vertex.smooth && IsBlack(vertex.weight) && IsBlack(vertex.emitted)) {
          // Nothing scattered; lamps, which reflect nothing in any direction, are left out.
          ++directions.drawn;
          ++directions.invalid;
        }
      }
    }
  return directions;
}

// None for path tracing; where methods race, of the one that was chosen.
Directions Watch(const CompiledJob& compiled, const Variant& v) {
  const std::unique_ptr<Method> method = MakeMethod(v.job, compiled.survey);
  return VisitGuide(*compiled.scene, *method, v.state,
                    [&]<class Guide>(const Guide& guide, const PathSettings& settings) {
                      if constexpr (Guide::kGuides) return Watch(*compiled.scene, settings.next_event, guide);
                      return Directions{};
                    });
}

double Sum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

double Mean(const std::vector<double>& values) {
  return Sum(values) / static_cast<double>(values.size());
}

// Standard error of the mean of `values` by seed, each over its own of `relative_to`.
double Spread(const std::vector<double>& values, const std::vector<double>& relative_to, double mean) {
  double squares = 0;
  for (size_t s = 0; s < values.size(); ++s) {
    const double deviation = values[s] / relative_to[s] - mean;
    squares += deviation * deviation;
  }
  const auto n = static_cast<double>(values.size());
  return n > 1 ? std::sqrt(squares / (n * (n - 1))) : 0;
}

void Print(const std::vector<Variant>& variants) {
  std::printf(
      "| variant | MSE | +- | MAE | +- | relMSE | time | rays | gain | rel | hits | +- | invalid | mean | +- | nodes "
      "|\n"
      "| --- |");
  for (int column = 1; column < 16; ++column) std::printf(" ---: |");
  std::printf("\n");
  const Variant& base = variants[0];
  const std::vector<double> ones(base.mse.size(), 1);
  for (const Variant& v : variants) {
    const double mse = Sum(v.mse) / Sum(base.mse), mae = Sum(v.mae) / Sum(base.mae),
                 relmse = Sum(v.relmse) / Sum(base.relmse), time = Median(v.seconds) / Median(base.seconds);
    std::printf(
        "| %s | %.4g | %.2g | %.3f | %.3f | %.4g | %.3f | %.3f | %.3g | %.3g | %.2f | %.2f | %.2f | %.5f | %.5f | %zu "
        "|\n",
        v.name.c_str(), mse, Spread(v.mse, base.mse, mse), mae, Spread(v.mae, base.mae, mae), relmse, time,
        v.rays / base.rays, 1 / (mse * time), 1 / (relmse * time), Mean(v.hits), Spread(v.hits, ones, Mean(v.hits)),
        Mean(v.invalid), Mean(v.mean), Spread(v.mean, ones, Mean(v.mean)), v.nodes);
  }
}

Image Reference(const CompiledJob& compiled, const JobSpec& common, const char* text) {
  JobSpec job = MakeVariant("path", common).job;
  job.seed = 77777;
  char* end = nullptr;
  job.budget.spp = std::strtoull(text, &end, 10);
  if (*end == 0) return RunLoop(compiled, job);
  return {common.resolution_x, common.resolution_y, ReadImage(text).pixels, {}};
}

int Run(int argc, char** argv) {
  if (argc < 9) {
    std::fprintf(stderr, "usage: guide_study SCENE.pbrt WIDTH HEIGHT DEPTH SPP SEEDS REFERENCE VARIANT...\n");
    return 2;
  }
  JobSpec common;
  common.resolution_x = static_cast<uint32_t>(std::atoi(argv[2]));
  common.resolution_y = static_cast<uint32_t>(std::atoi(argv[3]));
  common.max_depth = std::atoi(argv[4]);
  common.filter = "box";
  common.lenient = true;
  common.budget.spp = static_cast<uint64_t>(std::atoi(argv[5]));
  const int seeds = std::max(1, std::atoi(argv[6]));
  std::vector<Variant> variants;
  for (int i = 8; i < argc; ++i) variants.push_back(MakeVariant(argv[i], common));
  const CompiledJob compiled = CompileJob(ParsePbrtFile(argv[1]), common);

  const Image reference = Reference(compiled, common, argv[7]);
  for (int seed = 0; seed < seeds; ++seed)
    for (Variant& v : variants) {
      v.job.seed = static_cast<uint64_t>(seed);
      const double start = CpuSeconds();
      const Image image = RunLoop(compiled, v.job, &v);
      v.seconds.push_back(CpuSeconds() - start);
      const ErrorMetrics error = Compare(image, reference);
      v.mse.push_back(error.mse);
      v.mae.push_back(error.mae);
      v.relmse.push_back(error.relmse_trimmed);
      v.mean.push_back(Mean(image) / Mean(reference));
      const Directions directions = Watch(compiled, v);
      v.hits.push_back(directions.Percent(directions.hits));
      v.invalid.push_back(directions.Percent(directions.invalid));
    }
  std::printf("%s, %ux%u, depth %d, %s spp, %d seeds; the first: MSE %.4g, %.3g s\n\n", argv[1], common.resolution_x,
              common.resolution_y, compiled.survey.max_depth, argv[5], seeds, Sum(variants[0].mse) / seeds,
              Median(variants[0].seconds));
  Print(variants);
  return 0;
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  return lodestar::StudyMain(lodestar::Run, argc, argv);
}
