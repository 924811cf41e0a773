// The experiments of Nilsson 2023, section 5.2, on scenes of one's own: what reconstruction of the directional trees
// and switching of their target change in the error after 31 training samples a pixel.
//
//   build/release/bin/reconstruction_study STUDY WIDTHxHEIGHT[xPASSES] SEEDS SCENE.pbrt...
//
// STUDY: after         reconstruction after the last training iteration only, all from the same trees (table 5.2)
//        after-budget  the same after 3 to 63 training samples (figure 5.5)
//        during        reconstruction between all iterations, each target (table 5.3), and our defaults without and
//                      with it
//        sigma         the Gaussian's width (figure 5.2)
//        budget        3 to 63 training samples (figure 5.6)
//        time          at equal time, with and without the limit on the workload (tables 5.4 and 5.5)
//
// Relative errors are estimated from the variances of the last iteration alone (combine=discard), of PASSES samples a
// pixel, 64 unless given (more than 32, which the longest training has: the longest iteration is the image); the
// document renders 512, which divides all of them by the same 8. Next event estimation is on: without it 64 samples do
// not tell the error. Printed are means over the seeds; ratios are to the first row,
// geometric means, with the standard error of their logarithm, of the errors without the worst 0.1 % of the pixels and
// of those with them. An error falls as one over the time, so the ratio of error times time is the ratio of errors at
// equal time.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "bench/studied_method.h"
#include "bench/study_main.h"
#include "core/film/error_metrics.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"

namespace lodestar {
namespace {

struct Setting {
  std::string name;
  std::map<std::string, std::string> options;
  int training_iterations = 5;  // 31 passes
  // Reconstruction at the end of training only, of statistics that keep halves.
  std::optional<SdTreeOptions::Reconstruction> after_training = {};
};

// The 2019 settings, but next event estimation always.
Setting Paper(const std::string& name, const std::string& target, const std::string& reconstruction) {
  return {name,
          {{"preset", "2019"},
           {"nee", "always"},
           {"combine", "discard"},
           {"target", target},
           {"reconstruction", reconstruction}}};
}

Setting Default(const std::string& name, std::map<std::string, std::string> options) {
  options["combine"] = "discard";
  return {name, std::move(options)};
}

Setting WithSigma(Setting setting, const std::string& sigma) {
  setting.name += ", sigma " + sigma;
  setting.options["dense-sigma"] = sigma;
  return setting;
}

// Of the same trees; without the limit on the workload, which the document turns off there.
std::vector<Setting> AfterTraining(const std::string& name, int training_iterations) {
  using Reconstruction = SdTreeOptions::Reconstruction;
  const std::pair<const char*, Reconstruction> kinds[] = {
      {"", Reconstruction::kNone}, {", dense", Reconstruction::kDenseUnlimited}, {", native", Reconstruction::kNative}};
  std::vector<Setting> settings;
  for (const auto& [suffix, kind] : kinds) {
    settings.push_back(Paper(name + suffix, "full", "native"));  // native: halves are kept
    settings.back().training_iterations = training_iterations;
    settings.back().after_training = kind;
  }
  return settings;
}

std::vector<Setting> Settings(const std::string& study) {
  constexpr int kBudgets[] = {2, 3, 4, 5, 6};  // iterations
  const auto samples = [](int iterations) { return std::to_string((1 << iterations) - 1) + " samples, "; };
  std::vector<Setting> settings;
  if (study == "after") {
    settings = AfterTraining("full", 5);
  } else if (study == "after-budget") {
    for (const int iterations : kBudgets)
      for (Setting& setting : AfterTraining(samples(iterations) + "full", iterations))
        settings.push_back(std::move(setting));
  } else if (study == "during") {
    settings = {Paper("full", "full", "none"),
                Paper("full, dense", "full", "dense-unlimited"),
                Paper("full, native", "full", "native"),
                Paper("switching", "switching", "none"),
                Paper("switching, dense", "switching", "dense-unlimited"),
                WithSigma(Paper("switching, dense", "switching", "dense-unlimited"), "1.5"),
                Paper("switching, native", "switching", "native"),
                Paper("radiance", "radiance", "none"),
                Paper("radiance, native", "radiance", "native"),
                Default("defaults, not reconstructed", {{"reconstruction", "none"}}),
                Default("defaults, dense", {{"reconstruction", "dense"}}),
                WithSigma(Default("defaults, dense", {{"reconstruction", "dense"}}), "1.5"),
                Default("defaults", {})};
  } else if (study == "sigma") {
    settings.push_back(Paper("switching", "switching", "none"));
    for (const char* sigma : {"0.3", "0.5", "0.8", "1", "1.5"})
      settings.push_back(WithSigma(Paper("switching, dense", "switching", "dense-unlimited"), sigma));
    settings.push_back(Paper("switching, native", "switching", "native"));
  } else if (study == "time") {
    settings = {Paper("full", "full", "none"),
                Paper("switching", "switching", "none"),
                Paper("switching, dense, unlimited", "switching", "dense-unlimited"),
                Paper("switching, dense", "switching", "dense"),
                Paper("switching, native", "switching", "native"),
                Default("defaults, not reconstructed", {{"reconstruction", "none"}}),
                Default("defaults", {})};
  } else if (study == "budget") {
    for (const int iterations : kBudgets) {
      for (Setting setting :
           {Paper("full", "full", "none"), Paper("full, dense", "full", "dense-unlimited"),
            Paper("switching", "switching", "none"), Paper("switching, dense", "switching", "dense-unlimited"),
            Paper("switching, native", "switching", "native")}) {
        setting.name = samples(iterations) + setting.name;
        setting.training_iterations = iterations;
        settings.push_back(std::move(setting));
      }
    }
  }
  return settings;
}

struct Outcome {
  double error = 0, untrimmed = 0, seconds_learning = 0, seconds = 0;
};

// The job's budget is for what follows training.
Outcome Render(const CompiledJob& compiled, JobSpec job, const Setting& setting) {
  job.options = setting.options;
  job.training_iterations = setting.training_iterations;
  job.budget.spp += (uint64_t{1} << setting.training_iterations) - 1;
  const MethodFactory make_method = [&](const JobSpec& spec, const Survey& survey) -> std::unique_ptr<Method> {
    if (!setting.after_training) return MakeMethod(spec, survey);
    // Until training ends the trees are the same whatever comes.
    return std::make_unique<StudiedMethod>(spec, survey, [&](const IterationResult& result) {
      return result.last ? *setting.after_training : SdTreeOptions::Reconstruction::kNone;
    });
  };
  Loop loop(job, compiled.survey, make_method);
  // The tracing half knows the job's method by its own type.
  const std::unique_ptr<Method> method = MakeMethod(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, *method);
  loop.Run(executor, {}, {});
  const JobReport report = loop.Report();
  const EstimatedError error = EstimateError(loop.Develop());
  return {error.relmse_trimmed, error.relmse, report.seconds_learning, report.seconds};
}

// Ratios to those of the first setting, seed by seed.
class PairedRatio {
 public:
  void Add(double value, double baseline) {
    const double ratio = std::log(value / baseline);
    sum_ += ratio, squares_ += ratio * ratio, ++count_;
  }
  double mean() const { return std::exp(sum_ / count_); }
  // Of two seeds or more.
  double standard_error() const {
    const double mean = sum_ / count_;
    return std::sqrt(std::max(squares_ / count_ - mean * mean, 0.0) / (count_ - 1));
  }

 private:
  double sum_ = 0, squares_ = 0, count_ = 0;
};

struct Row {
  double error = 0, learning = 0;  // sums over the seeds
  PairedRatio errors, untrimmed, at_equal_time;
};

// Seed by seed, all settings one after the other, each time beginning with another one: a machine that grows slower
// meanwhile then shows in all of them alike.
void Study(const char* path, const JobSpec& job, uint64_t seeds, const std::vector<Setting>& settings) {
  const CompiledJob compiled = CompileJob(ParsePbrtFile(path), job);
  std::vector<Row> rows(settings.size());
  std::vector<Outcome> outcomes(settings.size());
  for (uint64_t seed = 0; seed < seeds; ++seed) {
    JobSpec seeded = job;
    seeded.seed = seed;
    for (size_t i = 0; i < settings.size(); ++i) {
      const size_t at = (i + seed) % settings.size();
      outcomes[at] = Render(compiled, seeded, settings[at]);
      std::fprintf(stderr, "\r%s: seed %llu, %zu of %zu ", path, static_cast<unsigned long long>(seed), i + 1,
                   settings.size());
    }
    const Outcome& baseline = outcomes.front();
    for (size_t i = 0; i < settings.size(); ++i) {
      const Outcome& outcome = outcomes[i];
      rows[i].error += outcome.error;
      rows[i].learning += outcome.seconds_learning / outcome.seconds;
      rows[i].errors.Add(outcome.error, baseline.error);
      rows[i].untrimmed.Add(outcome.untrimmed, baseline.untrimmed);
      rows[i].at_equal_time.Add(outcome.error * outcome.seconds, baseline.error * baseline.seconds);
    }
  }
  std::fprintf(stderr, "\r");
  std::printf(
      "\n%s, %ux%u, %llu passes, %llu seeds\n\n"
      "| setting | relMSE | ratio | +- | ratio, untrimmed | +- | ratio at equal time | +- | learning |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      path, job.resolution_x, job.resolution_y, static_cast<unsigned long long>(job.budget.spp),
      static_cast<unsigned long long>(seeds));
  const double n = static_cast<double>(seeds);
  for (size_t i = 0; i < settings.size(); ++i) {
    const Row& row = rows[i];
    std::printf("| %s | %.4g |", settings[i].name.c_str(), row.error / n);
    for (const PairedRatio& ratio : {row.errors, row.untrimmed, row.at_equal_time}) {
      std::printf(" %.3f |", ratio.mean());
      if (seeds > 1) std::printf(" %.1f %%", 100 * ratio.standard_error());
      std::printf(" |");
    }
    std::printf(" %.1f %% |\n", 100 * row.learning / n);
  }
  std::fflush(stdout);
}

int Run(int argc, char** argv) {
  const std::vector<Setting> settings = argc > 4 ? Settings(argv[1]) : std::vector<Setting>{};
  JobSpec job;
  job.method = "sdtree";
  job.filter = "box";
  const long seeds = argc > 4 ? std::strtol(argv[3], nullptr, 10) : 0;
  unsigned passes = 64;
  if (settings.empty() || seeds < 1 ||
      std::sscanf(argv[2], "%ux%ux%u", &job.resolution_x, &job.resolution_y, &passes) < 2 || passes <= 32) {
    std::fprintf(stderr,
                 "usage: reconstruction_study after|after-budget|during|sigma|budget|time WIDTHxHEIGHT[xPASSES] SEEDS "
                 "SCENE.pbrt...\n");
    return 2;
  }
  job.budget.spp = passes;
  for (int i = 4; i < argc; ++i) Study(argv[i], job, static_cast<uint64_t>(seeds), settings);
  return 0;
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  return lodestar::StudyMain(lodestar::Run, argc, argv);
}
