// lodestar render: a scene to an image, in this process.
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/interrupt.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"

namespace lodestar {
namespace {

struct RenderArguments {
  JobArguments job;
  std::string output, reference;
  int threads = 0;
  bool json = false, quiet = false;
};

ExitCode Render(const RenderArguments& arguments, const std::string& command_line) {
  // 1. Everything that can be wrong without rendering is found first.
  const JobSpec job = arguments.job.ToJob();
  const std::filesystem::path output =
      arguments.output.empty() ? std::filesystem::path(arguments.job.scene).filename().replace_extension(".exr")
                               : std::filesystem::path(arguments.output);
  const OutputPaths paths = OutputPaths::For(output);
  PrepareFolder(paths.image);
  std::shared_ptr<const Image> reference;
  if (!arguments.reference.empty()) reference = std::make_shared<const Image>(ReadImageFile(arguments.reference));

  // 2. The scene.
  const SceneDescription description = LoadScene(arguments.job.scene, arguments.job.lenient);
  const CompiledJob compiled = CompileScene(description, job);
  if (reference)
    CheckReferenceSize(*reference, arguments.reference, compiled.survey.resolution_x, compiled.survey.resolution_y);

  // 3. The render.
  StopToken stop;
  RenderResult result;
  {
    InterruptGuard guard(&stop);
    ProgressLine progress(arguments.quiet);
    result = RenderLocally(compiled, job, arguments.threads, reference, stop, progress);
  }
  const ExitCode code = InterruptGuard::Interrupted() ? ExitCode::kInterrupted : ExitCode::kOk;

  // 4. Its files.
  nlohmann::json report = CompleteReport(ReportToJson(result.report), {arguments.job.scene, command_line});
  if (result.report.passes == 0) {
    std::fprintf(stderr, "no file was written: the run ended before its first round\n");
  } else {
    report["files"] = DeliverRender(paths, result.image, report, job.method);
  }
  if (arguments.json) {
    std::cout << DumpJson(report) << "\n";
  } else {
    std::cout << Summary(report);
  }
  return code;
}

}  // namespace

void AddRenderCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* sub = app.add_subcommand("render", "Render a scene in this process");
  AddJobOptions(*sub, arguments->job);
  sub->add_option("-o,--output", arguments->output,
                  "Image: .exr (with variance and metadata), .png or .pfm; its name without the ending carries the "
                  ".png, .csv, .json and -error.png beside it "
                  "[SCENE.exr here]")
      ->type_name("FILE");
  sub->add_option("--reference", arguments->reference,
                  "Measure the error against this image (.exr, .pfm) of the same size")
      ->type_name("FILE");
  sub->add_option("--threads", arguments->threads, "Threads [those this process may use]; never changes the image")
      ->check(Unnamed(CLI::Range(1, 4096)));
  sub->add_flag("--json", arguments->json, "One JSON document on standard out: the report and the names of the files");
  sub->add_flag("--quiet", arguments->quiet, "No progress on standard error");
  sub->footer(
      "Examples:\n"
      "  lodestar render scenes/door-ajar.pbrt --time 60s -o out/door.exr\n"
      "  lodestar render scenes/cornell-box.pbrt --method path --spp 64 --resolution 256x256 --json\n"
      "  lodestar render scene.pbrt --error 0.01 --reference ref.exr --seed 3 -o out/scene.exr\n"
      "Ctrl-C ends at the last finished round and writes the image so far; a second one quits at once.");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] { return Render(*arguments, command_line); };
  });
}

}  // namespace lodestar
