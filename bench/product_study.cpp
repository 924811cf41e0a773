// The experiment of Diolatzis et al. 2020, section 4, on scenes of one's own: what product guiding changes in the error
// at equal samples and in the time to equal error.
//
//   build/release/bin/product_study papers|adrrs|defaults WIDTHxHEIGHT SPP SEEDS REFERENCE_SPP SCENE.pbrt...
//
// papers: the 2019 settings without next event estimation; adrrs: these with roulette by the pixel's expectation, as
// the document had it (section 4); defaults: ours, with next event estimation. L1 is against a reference by our
// defaults, rendered first, relMSE is estimated from the pixels' variances; both at SPP samples a pixel, training
// included. CPU is time of one thread, learning included, the least over the seeds. The time to equal L1 changes by the
// square of the ratio of L1 times that of the CPU time. Ratios are of means over the seeds;
// "+-" is the standard deviation of the ratios of single seeds.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "bench/study_main.h"
#include "core/film/error_metrics.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"

namespace lodestar {
namespace {

using Options = std::map<std::string, std::string>;

struct Outcome {
  Image image;
  double cpu = 0, rays_per_path = 0;
  double bsdf_fraction = 0;  // mean over the last records
};

Outcome Render(const CompiledJob& compiled, JobSpec job, const Options& options, uint64_t spp) {
  job.options = options;
  job.budget.spp = spp;
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), 1);
  const double start = CpuSeconds();
  loop.Run(executor, {}, {});
  Outcome outcome;
  outcome.cpu = (CpuSeconds() - start) / static_cast<double>(spp);
  outcome.image = loop.Develop();
  const JobReport report = loop.Report();
  outcome.rays_per_path = static_cast<double>(report.rays) / static_cast<double>(report.paths);
  const SdTree& tree = dynamic_cast<const SdTreeState&>(*loop.state()).tree();
  double records = 0;
  for (uint32_t i = 0; i < tree.leaf_count(); ++i) {
    const double weight = static_cast<double>(tree.leaf(i).records);
    outcome.bsdf_fraction += weight * static_cast<double>(tree.leaf(i).bsdf_fraction);
    records += weight;
  }
  outcome.bsdf_fraction /= records;
  return outcome;
}

// Of the product's to the plain method's.
struct Ratio {
  double mean = 0, deviation = 0;
  Ratio(const std::vector<double>& plain, const std::vector<double>& product) {
    const double n = static_cast<double>(plain.size());
    double a = 0, b = 0, first = 0, second = 0;
    for (size_t i = 0; i < plain.size(); ++i) {
      const double r = product[i] / plain[i];
      a += plain[i], b += product[i];
      first += r / n, second += r * r / n;
    }
    mean = b / a;
    deviation = std::sqrt(std::max(second - first * first, 0.0) * n / std::max(n - 1, 1.0));
  }
};

// The ratios whose geometric means over the scenes end the table.
struct Logarithms {
  double l1 = 0, relmse = 0, rays = 0, cpu = 0;
};

void Study(const char* path, const JobSpec& job, const Options& plain, uint64_t spp, uint64_t seeds,
           uint64_t reference_spp, Logarithms* sums) {
  const CompiledJob compiled = CompileJob(ParsePbrtFile(path), job);
  JobSpec reference_job = job;
  reference_job.seed = 1000003;
  const Image reference = Render(compiled, reference_job, {{"combine", "discard"}}, reference_spp).image;
  Options with_product = plain;
  with_product["product"] = "on";
  with_product["target"] = "radiance";
  struct Column {
    std::vector<double> l1, relmse;
    double cpu = 1e30, rays = 0, fraction = 0;
  } columns[2];
  for (uint64_t seed = 0; seed < seeds; ++seed) {
    JobSpec seeded = job;
    seeded.seed = seed;
    for (int product = 0; product < 2; ++product) {
      Column& column = columns[product];
      const Outcome outcome = Render(compiled, seeded, product ? with_product : plain, spp);
      column.l1.push_back(Compare(outcome.image, reference).mae);
      column.relmse.push_back(EstimateError(outcome.image).relmse_trimmed);
      column.cpu = std::min(column.cpu, outcome.cpu);
      column.rays += outcome.rays_per_path / static_cast<double>(seeds);
      column.fraction += outcome.bsdf_fraction / static_cast<double>(seeds);
    }
  }
  const Ratio l1(columns[0].l1, columns[1].l1), relmse(columns[0].relmse, columns[1].relmse);
  const double cpu = columns[1].cpu / columns[0].cpu, rays = columns[1].rays / columns[0].rays;
  const char* const name = std::strrchr(path, '/');
  std::printf("| %s | %.3f +- %.3f | %.3f +- %.3f | %.2f, %.2f | %.2f, %.2f | %.3f | %.3f | %.3f |\n",
              name ? name + 1 : path, l1.mean, l1.deviation, relmse.mean, relmse.deviation, columns[0].rays,
              columns[1].rays, columns[0].fraction, columns[1].fraction, cpu, l1.mean * l1.mean * cpu,
              relmse.mean * cpu);
  std::fflush(stdout);
  sums->l1 += std::log(l1.mean), sums->relmse += std::log(relmse.mean);
  sums->cpu += std::log(cpu), sums->rays += std::log(rays);
}

int Run(int argc, char** argv) {
  JobSpec job;
  job.method = "sdtree";
  job.filter = "box";
  const std::map<std::string, Options> settings = {
      {"papers", {{"preset", "2019"}, {"nee", "never"}}},
      {"adrrs", {{"preset", "2019"}, {"nee", "never"}, {"roulette", "pixel"}}},
      {"defaults", {}}};
  const auto plain = argc > 1 ? settings.find(argv[1]) : settings.end();
  const auto number = [&](int i) { return argc > i ? std::strtol(argv[i], nullptr, 10) : 0; };
  const long spp = number(3), seeds = number(4), reference_spp = number(5), scenes = argc - 6;
  if (scenes < 1 || spp < 1 || seeds < 1 || reference_spp < 1 || plain == settings.end() ||
      std::sscanf(argv[2], "%ux%u", &job.resolution_x, &job.resolution_y) != 2) {
    std::fprintf(stderr,
                 "usage: product_study papers|adrrs|defaults WIDTHxHEIGHT SPP SEEDS REFERENCE_SPP SCENE.pbrt...\n");
    return 2;
  }
  std::printf(
      "With product / without, %s settings, %s, %ld samples, %ld seeds\n\n"
      "| scene | L1 | relMSE | rays a path | BSDF fraction | CPU | time to equal L1 | to equal relMSE |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      argv[1], argv[2], spp, seeds);
  Logarithms sums;
  for (int i = 6; i < argc; ++i)
    Study(argv[i], job, plain->second, static_cast<uint64_t>(spp), static_cast<uint64_t>(seeds),
          static_cast<uint64_t>(reference_spp), &sums);
  const auto mean = [&](double sum) { return std::exp(sum / static_cast<double>(scenes)); };
  std::printf("| geometric mean | %.3f | %.3f | x %.3f | | %.3f | %.3f | %.3f |\n", mean(sums.l1), mean(sums.relmse),
              mean(sums.rays), mean(sums.cpu), mean(2 * sums.l1 + sums.cpu), mean(sums.relmse + sums.cpu));
  return 0;
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  return lodestar::StudyMain(lodestar::Run, argc, argv);
}
