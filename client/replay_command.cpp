// lodestar replay: one pixel sample again, as the health report's command asks for.
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "client/command.h"
#include "client/interrupt.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"
#include "core/learning/report_json.h"
#include "core/tracing/local_executor.h"

namespace lodestar {
namespace {

struct ReplayArguments {
  JobArguments job;
  std::string pixel;
  uint32_t pass = 0, iteration = 0;
  int threads = 0;
  bool json = false;
};

struct Sample {
  Rgb radiance;
  HealthReport health;  // of the pixel's tile in this pass
};

// Renders the job's rounds up to the sample's, or its last iteration's first, so that its state is the one that was in
// use; then the sample alone.
class ReplayExecutor final : public Executor {
 public:
  ReplayExecutor(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method,
                 const ReplayArguments& arguments, Pixel pixel, StopToken* found)
      : scene_(scene),
        job_(job),
        method_(method),
        iteration_(arguments.iteration),
        pass_(arguments.pass),
        pixel_(pixel),
        found_(found),
        local_(scene, job, method, arguments.threads) {}

  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override {
    // The last iteration, which does not record, takes all passes that are left, under one state: none of them need be
    // rendered first.
    const bool here = round.iteration == iteration_ && pass_ >= round.first_pass &&
                      (!round.record || pass_ < round.first_pass + round.passes);
    if (!here) return local_.Execute(state, round, stop);
    Round single = round;
    single.first_pass = pass_;
    single.passes = 1;
    sample_ = Trace(state, single, stop);
    found_->Request();  // the loop has nothing more to do
    return std::nullopt;
  }
  const std::optional<Sample>& sample() const { return sample_; }

 private:
  std::optional<Sample> Trace(const std::shared_ptr<const State>& state, const Round& round,
                              const StopToken& stop) const {
    const auto tracer = PrepareTracer(scene_, job_, method_, state);
    Sample sample;
    sample.radiance = tracer->TraceSample(round, pixel_.x, pixel_.y, pass_);
    Contribution contribution;
    if (round.record) contribution.statistics = method_.NewStatistics(state);
    const TileGrid grid(static_cast<uint32_t>(scene_->resolution_x()), static_cast<uint32_t>(scene_->resolution_y()));
    if (!tracer->Execute(round, grid.TileAt(pixel_.x, pixel_.y), stop, &contribution)) return std::nullopt;
    sample.health = contribution.health;
    return sample;
  }

  std::shared_ptr<const Scene> scene_;
  const JobSpec& job_;
  const Method& method_;
  uint32_t iteration_, pass_;
  Pixel pixel_;
  StopToken* found_;
  LocalExecutor local_;
  std::optional<Sample> sample_;
};

ExitCode Replay(const ReplayArguments& arguments) {
  JobSpec job = arguments.job.ToJob();
  const Pixel pixel = ParsePixel(arguments.pixel);
  if (job.budget.spp == 0) job.budget.spp = uint64_t{arguments.pass} + 1;
  if (job.budget.spp <= arguments.pass) {
    throw Error(ErrorKind::kInvalidInput,
                "--pass " + std::to_string(arguments.pass) + " is not below --spp " + std::to_string(job.budget.spp));
  }
  const SceneDescription description = LoadScene(arguments.job.scene, {.lenient = arguments.job.lenient});
  const CompiledJob compiled = CompileScene(description, job);
  if (pixel.x >= compiled.survey.resolution_x || pixel.y >= compiled.survey.resolution_y) {
    throw Error(ErrorKind::kInvalidInput, "--pixel " + arguments.pixel + " lies outside the image of " +
                                              std::to_string(compiled.survey.resolution_x) + "x" +
                                              std::to_string(compiled.survey.resolution_y));
  }
  StopToken stop;
  Loop loop(job, compiled.survey);
  ReplayExecutor executor(compiled.scene, job, loop.method(), arguments, pixel, &stop);
  {
    InterruptGuard guard(&stop, "stopping");
    loop.Run(executor, stop, {});
  }
  if (InterruptGuard::Interrupted()) return ExitCode::kInterrupted;
  if (!executor.sample()) {
    throw Error(ErrorKind::kInvalidInput,
                "this job has no pass " + std::to_string(arguments.pass) + " in iteration " +
                    std::to_string(arguments.iteration) +
                    "; give --method, --option, --spp and --training-iterations as the health report printed them");
  }
  const Rgb c = executor.sample()->radiance;
  char bits[96];
  std::snprintf(bits, sizeof bits, "%a %a %a", static_cast<double>(c.r), static_cast<double>(c.g),
                static_cast<double>(c.b));
  const auto& first = executor.sample()->health.first;
  const bool offends =
      first.exists() && first.pixel_x == pixel.x && first.pixel_y == pixel.y && first.pass == arguments.pass;
  const char* event = offends ? HealthEventName(first.event) : "";
  if (arguments.json) {
    nlohmann::json json = {{"pixel", {pixel.x, pixel.y}},
                           {"pass", arguments.pass},
                           {"iteration", arguments.iteration},
                           {"radiance", {c.r, c.g, c.b}},
                           {"bits", bits}};
    if (offends) json["event"] = event;
    std::cout << DumpJson(json) << "\n";
  } else {
    std::cout << "radiance " << c.r << " " << c.g << " " << c.b << "\nbits     " << bits << "\n";
    if (offends) std::cout << "health   " << event << "\n";
  }
  return ExitCode::kOk;
}

}  // namespace

void AddReplayCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* sub = app.add_subcommand("replay", "Render one pixel sample again, as a health report asks");
  AddJobOptions(*sub, arguments->job, {.method = true, .budget = false});
  sub->add_option("--spp", arguments->job.spp, "Samples per pixel the job ended with [pass + 1]")->check(AboveZero());
  sub->add_option("--pixel", arguments->pixel, "The pixel, (0,0) the upper left one")->required()->type_name("X,Y");
  sub->add_option("--pass", arguments->pass, "The pass, counted through the whole job from 0")->required();
  sub->add_option("--iteration", arguments->iteration, "The training iteration whose state was in use")
      ->capture_default_str();
  sub->add_option("--threads", arguments->threads, "Threads [those this process may use]")
      ->check(Unnamed(CLI::Range(1, 4096)));
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->footer(
      "The health report of a render prints the whole command.\nExample:\n  lodestar replay scenes/cornell-box.pbrt "
      "--method path --pixel 12,34 --pass 7");
  sub->callback([arguments, &invocation] { invocation.run = [arguments] { return Replay(*arguments); }; });
}

}  // namespace lodestar
