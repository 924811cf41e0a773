// lodestar compare: several methods on one scene at equal time or equal samples, over several seeds.
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/comparison.h"
#include "client/delivery.h"
#include "client/interrupt.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/plot.h"
#include "client/values.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

namespace fs = std::filesystem;

struct CompareArguments {
  JobArguments job;
  std::string methods = "path,sdtree", reference, output;
  int seeds = 3, threads = 0;
  bool json = false, quiet = false;
};

struct Contender {
  MethodChoice choice;
  JobSpec job;
};

std::vector<Contender> Contenders(const CompareArguments& arguments) {
  std::vector<Contender> contenders;
  for (const std::string& text : SplitMethods(arguments.methods)) {
    Contender contender;
    contender.choice = ParseMethodChoice(text);
    JobArguments job = arguments.job;
    job.method = contender.choice.method;
    contender.job = job.ToJob();
    contender.job.options = contender.choice.options;
    for (const Contender& other : contenders) {
      if (other.choice.label == text) throw Error(ErrorKind::kInvalidInput, "--methods names '" + text + "' twice");
    }
    contenders.push_back(std::move(contender));
  }
  if (contenders.empty())
    throw Error(ErrorKind::kInvalidInput, "--methods is empty; name at least one, e.g. path,sdtree");
  return contenders;
}

// Renders one seed of one method and writes its image, picture and error map.
ComparisonRun RunOne(const CompareArguments& arguments, const CompiledJob& compiled, const Contender& contender,
                     uint64_t seed, const std::shared_ptr<const Image>& reference, const StopToken& stop,
                     const std::string& command_line) {
  JobSpec job = contender.job;
  job.seed = seed;
  ProgressLine progress(arguments.quiet);
  RenderResult result = RenderLocally(compiled, job, arguments.threads, reference, stop, progress);
  ComparisonRun run;
  run.label = contender.choice.label;
  run.seed = seed;
  run.report = std::move(result.report);
  if (run.report.passes == 0) return run;
  const fs::path folder = arguments.output;
  const std::string stem = FileLabel(run.label) + "-seed" + std::to_string(seed);
  WriteImage(folder / (stem + ".exr"), result.image,
             ImageMetadata(CompleteReport(ReportToJson(run.report), {arguments.job.scene, command_line})));
  run.picture = stem + ".png";
  WriteImage(folder / run.picture, result.image, {});
  if (reference) {
    run.metrics = Compare(result.image, *reference);
    run.map = stem + "-map.png";
    WritePng((folder / run.map).string(), result.image.width, result.image.height,
             FalseColour(RelativeLuminanceError(result.image, *reference)));
  }
  return run;
}

ExitCode CompareMethods(const CompareArguments& arguments, const std::string& command_line) {
  // 1. What to run.
  const std::vector<Contender> contenders = Contenders(arguments);
  const fs::path folder = arguments.output;
  PrepareFolder(folder / "compare.csv");
  std::shared_ptr<const Image> reference;
  if (!arguments.reference.empty()) reference = std::make_shared<const Image>(ReadImageFile(arguments.reference));
  const SceneDescription description = LoadScene(arguments.job.scene, {.lenient = arguments.job.lenient});
  const CompiledJob compiled = CompileScene(description, contenders.front().job);
  if (reference)
    CheckReference(*reference, arguments.reference, compiled.survey.resolution_x, compiled.survey.resolution_y);
  for (const Contender& contender : contenders)
    MakeMethod(contender.job, compiled.survey);  // refuses bad values before the first render

  // 2. All methods of a seed before the next seed: a machine that slows down slows all of them.
  std::vector<ComparisonRun> runs;
  StopToken stop;
  const InterruptGuard guard(&stop, "stopping: the runs that are complete will be reported");
  for (int i = 0; i < arguments.seeds; ++i) {
    for (const Contender& contender : contenders) {
      if (stop.Requested()) break;
      const uint64_t seed = arguments.job.seed + static_cast<uint64_t>(i);
      if (!arguments.quiet)
        std::fprintf(stderr, "%s, seed %llu\n", contender.choice.label.c_str(), static_cast<unsigned long long>(seed));
      ComparisonRun run = RunOne(arguments, compiled, contender, seed, reference, stop, command_line);
      // One cut short would be compared with whole ones.
      if (run.report.stop_reason != "stopped") runs.push_back(std::move(run));
    }
  }
  const ExitCode code = InterruptGuard::Interrupted() ? ExitCode::kInterrupted : ExitCode::kOk;
  if (runs.empty()) {
    std::fprintf(stderr, "no run was finished: nothing to report\n");
    return code;
  }

  // 3. The report. What the budget made equal is in its first table; the second has the other.
  const EqualBy by = contenders.front().job.budget.seconds > 0 ? EqualBy::kSamples : EqualBy::kTime;
  std::string csv = kCsvHeader;
  for (const ComparisonRun& run : runs) csv += PointsToCsv(run.label, run.seed, run.report.points);
  WriteText(folder / "compare.csv", csv);
  nlohmann::json document = {{"scene", arguments.job.scene},
                             {"command", command_line},
                             {"reference", arguments.reference},
                             {"methods", Summarize(runs)},
                             {"equal", AtEqual(runs, by)}};
  const bool plotted = DrawErrorPlot(folder / "compare.csv", folder / "compare-error.png",
                                     fs::path(arguments.job.scene).stem().string());
  document["plot"] = plotted ? nlohmann::json("compare-error.png") : nlohmann::json(nullptr);
  WriteText(folder / "compare.json", DumpJson(document) + "\n");
  const std::string markdown = MarkdownReport(document);
  WriteText(folder / "report.md", markdown);
  WriteText(folder / "report.html", HtmlReport(document));
  if (arguments.json) {
    std::cout << DumpJson(document) << "\n";
  } else {
    std::cout << markdown.substr(0, markdown.find("\n![")) << "\nreport  " << (folder / "report.html").string() << "\n";
  }
  return code;
}

}  // namespace

void AddCompareCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* sub = app.add_subcommand("compare", "Render a scene with several methods and compare their errors");
  AddJobOptions(*sub, arguments->job, {.method = false, .budget = true});
  sub->add_option("--methods", arguments->methods,
                  "Methods with their options, e.g. path,sdtree:nee=always,combine=discard; the first is the baseline. "
                  "In a value that is a list slashes stand for its commas: auto:candidates=path/sdtree")
      ->capture_default_str()
      ->type_name("LIST");
  sub->add_option("--seeds", arguments->seeds, "Runs of each method, with seeds --seed, --seed + 1, ...")
      ->capture_default_str()
      ->check(Unnamed(CLI::Range(1, 10000)));
  sub->add_option("--reference", arguments->reference,
                  "Measure the error against this image of the same size [estimate it from the variances]")
      ->type_name("FILE");
  sub->add_option("-o,--output", arguments->output,
                  "Folder for report.html, report.md, compare.csv, compare.json, the plot, images and error maps")
      ->required()
      ->type_name("DIR");
  sub->add_option("--threads", arguments->threads, "Threads [those this process may use]")
      ->check(Unnamed(CLI::Range(1, 4096)));
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->add_flag("--quiet", arguments->quiet, "No progress on standard error");
  sub->footer(
      "Examples:\n"
      "  lodestar compare scenes/door-ajar.pbrt --time 60s --seeds 3 --reference ref.exr -o out/report\n"
      "  lodestar compare scene.pbrt --methods path,sdtree,sdtree:combine=discard --spp 128 -o out/report");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] {
      return CompareMethods(*arguments, command_line);
    };
  });
}

}  // namespace lodestar
