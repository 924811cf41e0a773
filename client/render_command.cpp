// lodestar render: a scene to an image, in this process.
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/delivery.h"
#include "client/guide_aovs.h"
#include "client/interim_pictures.h"
#include "client/interrupt.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

struct RenderArguments {
  JobArguments job;
  std::string output, reference, state, aovs;
  int threads = 0;
  bool json = false, quiet = false;
};

// Refuses, before anything is rendered, what the method cannot give.
void CheckExtras(const RenderArguments& arguments, const AovChoice& aovs, const CompiledJob& compiled,
                 const JobSpec& job) {
  if (!arguments.state.empty()) CheckLearns(compiled, job);
  if (!aovs.shares()) return;
  const std::unique_ptr<Method> method = MakeMethod(job, compiled.survey);
  SharesOf(*compiled.scene, *method, method->Initial());
}

Features RenderAovs(const AovChoice& aovs, const CompiledJob& compiled, const JobSpec& job,
                    const std::shared_ptr<const State>& state, int threads) {
  SharesAt shares = [](const SurfaceHit&) { return TechniqueShares{}; };
  if (aovs.shares()) shares = SharesOf(*compiled.scene, *MakeMethod(job, compiled.survey), state);
  return RenderFeatures(*compiled.scene, job.seed, shares, threads);
}

ExitCode Render(const RenderArguments& arguments, const std::string& command_line) {
  // 1. Everything that can be wrong without rendering is found first.
  const JobSpec job = arguments.job.ToJob();
  const std::filesystem::path output =
      arguments.output.empty() ? std::filesystem::path(arguments.job.scene).filename().replace_extension(".exr")
                               : std::filesystem::path(arguments.output);
  const OutputPaths paths = OutputPaths::For(output);
  PrepareFolder(paths.image);
  const AovChoice aovs = AovChoice::Parse(arguments.aovs);
  if (aovs.any() && Ending(paths.image) != ".exr")
    throw Error(ErrorKind::kInvalidInput,
                "--aov needs an image that ends in .exr: other files have no room for channels");
  if (!arguments.state.empty()) PrepareFolder(arguments.state);
  std::shared_ptr<const Image> reference;
  if (!arguments.reference.empty()) reference = std::make_shared<const Image>(ReadImageFile(arguments.reference));

  // 2. The scene.
  const SceneDescription description = LoadScene(arguments.job.scene, {.lenient = arguments.job.lenient});
  const CompiledJob compiled = CompileScene(description, job);
  if (reference)
    CheckReference(*reference, arguments.reference, compiled.survey.resolution_x, compiled.survey.resolution_y);

  CheckExtras(arguments, aovs, compiled, job);

  // 3. The render, and now and then its picture so far. The last one is among the files of step 4.
  StopToken stop;
  const InterruptGuard guard(&stop, "stopping: the image so far will be written");
  const ReportContext context = {arguments.job.scene, command_line};
  RenderResult result;
  GuideFile guide;
  {
    ProgressLine progress(arguments.quiet);
    InterimPictures pictures(paths, progress);
    const auto after_round = [&](const Loop& loop, const JobProgress& at) {
      if (loop.finished()) return;
      pictures.Update(at.seconds, [&]() -> InterimPictures::Picture {
        return {loop.Develop(), ImageMetadata(CompleteReport(ReportToJson(loop.Report()), context))};
      });
    };
    result = RenderLocally(compiled, job, arguments.threads, reference, stop, progress,
                           arguments.state.empty() ? nullptr : &guide, after_round);
  }
  const ExitCode code = InterruptGuard::Interrupted() ? ExitCode::kInterrupted : ExitCode::kOk;

  // 4. Its files. Where one cannot be written the others are, and the command fails at its end.
  nlohmann::json report = CompleteReport(ReportToJson(result.report), context);
  report["result"]["seconds_compiling"] = compiled.seconds;
  Failures failures;
  if (result.report.passes == 0) {
    std::fprintf(stderr, "no file was written: the run ended before its first round\n");
  } else {
    Features features;
    RenderExtras extras;
    if (aovs.any() &&
        failures.Try([&] { features = RenderAovs(aovs, compiled, job, result.state, arguments.threads); })) {
      extras.aovs = AovChannels(aovs, features);
      if (aovs.bsdf_fraction) {
        const std::filesystem::path picture =
            std::filesystem::path(paths.image).replace_extension().string() + "-bsdf-fraction.png";
        extras.files.push_back({"fraction", picture, [&features, picture] { WriteFractionPng(picture, features); }});
      }
    }
    if (!arguments.state.empty()) {
      extras.files.push_back(
          {"state", arguments.state, [&arguments, &guide] { WriteText(arguments.state, guide.Serialize()); }});
    }
    report["files"] = DeliverRender(paths, result.image, report, job.method, failures, extras);
  }
  if (arguments.json) {
    std::cout << DumpJson(report) << "\n";
  } else {
    std::cout << Summary(report);
  }
  failures.Throw();
  return code;
}

}  // namespace

void AddRenderCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* sub = app.add_subcommand("render", "Render a scene in this process");
  AddJobOptions(*sub, arguments->job);
  sub->add_option("-o,--output", arguments->output,
                  "Image: .exr (with variance and metadata), .png or .pfm; its name without the ending carries the "
                  ".png, .csv, .json and -error.png beside it. It and the .png are written now and then while it "
                  "renders, too [SCENE.exr here]")
      ->type_name("FILE");
  sub->add_option("--reference", arguments->reference,
                  "Measure the error against this image (.exr, .pfm) of the same size")
      ->type_name("FILE");
  sub->add_option("--state", arguments->state,
                  "Save what was learned, for `lodestar inspect --guide FILE`; not with methods that learn nothing")
      ->type_name("FILE");
  sub->add_option("--aov", arguments->aovs,
                  "More channels of the .exr, of what the camera sees first, rendered once after the image: albedo "
                  "(albedo.R, .G, .B), normal (N.X, .Y, .Z, world space), depth (Z, along the ray), and at the first "
                  "surface that is no mirror or glass what the method does: bsdf-fraction (guide.bsdf_fraction, and a "
                  "false-colour OUT-bsdf-fraction.png: blue guided, orange by the BSDF), nee (guide.nee, the share of "
                  "vertices that sample a light) [none]")
      ->type_name("NAME,...");
  sub->add_option("--threads", arguments->threads,
                  "Threads [those this process may use]; the image depends on them only with --time")
      ->check(Unnamed(CLI::Range(1, 4096)));
  sub->add_flag("--json", arguments->json, "One JSON document on standard out: the report and the names of the files");
  sub->add_flag("--quiet", arguments->quiet, "No progress on standard error");
  sub->footer(
      "Examples:\n"
      "  lodestar render scenes/door-ajar.pbrt --time 60s -o out/door.exr\n"
      "  lodestar render scenes/cornell-box.pbrt --method path --spp 64 --resolution 256x256 --json\n"
      "  lodestar render scene.pbrt --error 0.01 --reference ref.exr --seed 3 -o out/scene.exr\n"
      "  lodestar render scenes/door-ajar.pbrt --spp 64 -o out/door.exr --aov albedo,normal,depth,bsdf-fraction\n"
      "  lodestar render scenes/door-ajar.pbrt --spp 64 -o out/door.exr --state out/door.lguide\n"
      "Ctrl-C ends at the last finished round and writes the image so far; a second one quits at once.");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] { return Render(*arguments, command_line); };
  });
}

}  // namespace lodestar
