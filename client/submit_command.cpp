// lodestar submit: a scene to the farm. It is compiled here first, so that what is wrong with it is said before
// anything is uploaded.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "client/command.h"
#include "client/farm_session.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

struct SubmitArguments {
  JobArguments job;
  FarmAddress farm;
  std::string name, reference;
  FollowOptions follow;
  int priority = 0;
  uint32_t threads = 0;
  bool watch = false;
};

SceneManifest Upload(FarmClient& farm, const SceneDescription& description, bool quiet) {
  const SceneBundle bundle = BundleScene(description.files);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  bool open = false;
  const SceneManifest manifest = OnFarm([&] {
    return farm.Upload(bundle, [&](const UploadProgress& at) {
      if (quiet || !terminal) return;
      std::fprintf(stderr, "\ruploading %zu of %zu files, %s of %s\x1b[K", at.files_done, at.files,
                   FormatBytes(static_cast<double>(at.bytes_done)).c_str(),
                   FormatBytes(static_cast<double>(at.bytes)).c_str());
      open = true;
    });
  });
  if (open) std::fputc('\n', stderr);
  return manifest;
}

ExitCode Submit(const SubmitArguments& arguments, const std::string& command_line) {
  JobSubmission submission;
  submission.spec = arguments.job.ToJob();
  submission.priority = arguments.priority;
  submission.threads = arguments.threads;
  submission.name =
      arguments.name.empty() ? std::filesystem::path(arguments.job.scene).stem().string() : arguments.name;
  submission.scene_path = std::filesystem::absolute(arguments.job.scene).string();
  FollowOptions follow = arguments.follow;
  follow.command_line = command_line;
  PrepareDelivery(follow);
  std::optional<Image> reference;
  if (!arguments.reference.empty()) reference = ReadImageFile(arguments.reference);

  // Any folder, but by relative names: workers have others.
  const SceneDescription description =
      LoadScene(arguments.job.scene, {.lenient = arguments.job.lenient, .within = "/"});
  {
    const CompiledJob compiled = CompileScene(description, submission.spec);
    MakeMethod(submission.spec, compiled.survey);  // refuses bad values of options here and now
    if (!follow.state.empty()) CheckLearns(compiled, submission.spec);
    if (reference) {
      CheckReference(*reference, arguments.reference, compiled.survey.resolution_x, compiled.survey.resolution_y);
    }
  }
  FarmClient farm(arguments.farm.address, arguments.farm.options);
  if (reference) OnFarm([&] { return farm.UploadImage(*reference); });
  submission.scene = Upload(farm, description, follow.quiet);
  // Again: while a large scene is uploaded nobody asks for it, and it may have been dropped.
  if (reference) submission.reference = OnFarm([&] { return farm.UploadImage(*reference); });
  const JobId id = OnFarm([&] { return farm.SubmitJob(submission); });
  if (arguments.watch || !follow.output.empty()) {
    if (!follow.quiet) std::fprintf(stderr, "submitted %s\n", id.value.c_str());
    return FollowJob(farm, id, follow);
  }
  if (follow.json) {
    std::cout << DumpJson({{"job", id.value}, {"name", submission.name}, {"farm", arguments.farm.address}}) << "\n";
  } else {
    std::cout << id.value << "\n";
  }
  return ExitCode::kOk;
}

}  // namespace

void AddSubmitCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<SubmitArguments>();
  CLI::App* sub = app.add_subcommand("submit", "Give a scene to the farm");
  AddJobOptions(*sub, arguments->job);
  AddFarmOption(*sub, arguments->farm);
  sub->add_option("--name", arguments->name, "Name of the job in lists [the scene's]")->type_name("TEXT");
  sub->add_option("--priority", arguments->priority, "Larger comes first")->capture_default_str();
  sub->add_option(
         "--threads", arguments->threads,
         "Each worker renders the job on at most so many threads [all that it has]; the image depends on them only "
         "with --time")
      ->check(Unnamed(CLI::Range(1, 4096)));
  sub->add_flag("--watch", arguments->watch, "Show progress until the job ends");
  sub->add_option("-o,--output", arguments->follow.output,
                  "Wait for the job and write the image and its .png now and then and at the end, and then .csv, .json "
                  "and -error.png (as render does)")
      ->type_name("FILE");
  sub->add_option("--reference", arguments->reference,
                  "Measure the error against this image (.exr, .pfm) of the same size; it is sent along, and every "
                  "point of the report has it")
      ->type_name("FILE");
  AddStateOption(*sub, arguments->follow);
  sub->add_flag("--json", arguments->follow.json, "One JSON document on standard out");
  sub->add_flag("--quiet", arguments->follow.quiet, "No progress on standard error");
  sub->footer(
      "Examples:\n"
      "  lodestar submit scenes/door-ajar.pbrt --farm localhost:7420 --spp 256 --watch -o out/door.exr\n"
      "  lodestar submit scene.pbrt --time 5m --priority 2 --json\n"
      "Ctrl-C ends the watching, not the job.");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] { return Submit(*arguments, command_line); };
  });
}

}  // namespace lodestar
