#include "client/farm_session.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "client/command.h"
#include "client/delivery.h"
#include "client/interim_pictures.h"
#include "client/interrupt.h"
#include "client/progress.h"
#include "client/values.h"
#include "core/film/error_metrics.h"
#include "core/learning/report_json.h"
#include "rpc/status.h"

namespace lodestar {
namespace {

using Json = nlohmann::json;

// gRPC would take another port for one that is missing, no number or too large.
std::string CheckAddress(const std::string& address) {
  const size_t colon = address.rfind(':');
  uint16_t port = 0;
  if (colon != std::string::npos && colon > 0) {
    const char* const end = address.data() + address.size();
    const auto [stopped_at, error] = std::from_chars(address.data() + colon + 1, end, port);
    if (error == std::errc() && stopped_at == end && port > 0) return "";
  }
  return "'" + address + "' must be HOST:PORT, as in localhost:7420";
}

// What the job waits for, said once each time it changes.
void SayWaiting(const JobStatus& status, std::string* said) {
  const std::string words =
      status.phase == JobPhase::kQueued && status.waiting_for.empty() ? "queued" : status.waiting_for;
  if (!words.empty() && words != *said) std::fprintf(stderr, "%s: %s\n", status.id.value.c_str(), words.c_str());
  *said = words;
}

// The picture so far of a job that runs; nothing where the farm does not give it now, since there will be others.
std::optional<InterimPictures::Picture> FetchPicture(FarmClient& farm, const JobStatus& status,
                                                     const std::string& command_line) {
  try {
    Image image = farm.GetImage(status.id);
    return InterimPictures::Picture{std::move(image), ImageMetadata(FetchReport(farm, status, command_line))};
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

}  // namespace

void AddFarmOption(CLI::App& app, FarmAddress& farm) {
  app.add_option("--farm", farm.address, "The coordinator")
      ->envname("LODESTAR_FARM")
      ->capture_default_str()
      ->type_name("HOST:PORT")
      ->check(CheckAddress);
  app.add_option("--retry", farm.options.retry_seconds, "Seconds to go on trying while the coordinator does not answer")
      ->check(ZeroOrAbove())
      ->capture_default_str();
}

void AddStateOption(CLI::App& app, FollowOptions& options) {
  app.add_option("--state", options.state,
                 "With -o: save what was learned as well, for `lodestar inspect --guide FILE`; not with methods that "
                 "learn nothing")
      ->type_name("FILE");
}

void PrepareDelivery(const FollowOptions& options) {
  if (!options.state.empty() && options.output.empty())
    throw Error(ErrorKind::kInvalidInput, "--state needs -o: what was learned is fetched with the image");
  if (!options.reference.empty() && options.output.empty())
    throw Error(ErrorKind::kInvalidInput, "--reference needs -o: the image that is fetched is measured");
  // What is wrong with it is said now, not when the job has ended.
  if (!options.reference.empty()) (void)ReadImageFile(options.reference);
  if (!options.output.empty()) PrepareFolder(OutputPaths::For(options.output).image);
  if (!options.state.empty()) PrepareFolder(options.state);
}

void ThrowFarmError(const Error& error) {
  if (dynamic_cast<const UnreachableError*>(&error)) {
    throw CommandError(ExitCode::kFarmUnreachable,
                       std::string(error.what()) + "\nthe address comes from --farm HOST:PORT or LODESTAR_FARM");
  }
  throw CommandError(ExitCode::kJobFailed, std::string("the farm refused: ") + error.what());
}

JobProgress ProgressOf(const JobStatus& status) {
  JobProgress progress = status.progress;
  if (status.phase == JobPhase::kDone) progress.fraction = 1;
  return progress;
}

Json StatusToJson(const JobStatus& status) {
  return {{"job", status.id.value},
          {"name", status.name},
          {"priority", status.priority},
          {"method", status.method},
          {"phase", JobPhaseName(status.phase)},
          {"error", status.error},
          {"log", status.log},
          {"submitted_unix_ms", status.submitted_unix_ms},
          {"iteration", status.progress.iteration},
          {"spp", status.progress.passes},
          {"seconds", status.progress.seconds},
          {"relmse_estimated", status.progress.relmse_estimated},
          {"fraction", status.progress.fraction},
          {"seconds_left", status.progress.seconds_left >= 0 ? Json(status.progress.seconds_left) : Json(nullptr)},
          {"rays", status.progress.rays},
          {"resolution", {status.width, status.height}},
          {"waiting_for", status.waiting_for}};
}

std::string StatusLine(const JobStatus& status) {
  char line[256];
  const std::string error = status.progress.relmse_estimated > 0 && std::isfinite(status.progress.relmse_estimated)
                                ? FormatNumber(status.progress.relmse_estimated)
                                : "-";
  std::snprintf(line, sizeof line, "%-10s %-9s %3.0f%%  %-8s %7llu spp  error %-8s  %8s left  ",
                status.id.value.c_str(), JobPhaseName(status.phase), 100 * ProgressOf(status).fraction,
                status.method.c_str(), static_cast<unsigned long long>(status.progress.passes), error.c_str(),
                FormatDuration(Ended(status.phase) ? 0 : status.progress.seconds_left).c_str());
  std::string text = line + status.name;
  if (!status.error.empty())
    text += "\n    " + status.error;
  else if (!status.waiting_for.empty())
    text += "\n    waiting for " + status.waiting_for;
  return text;
}

Json FetchReport(FarmClient& farm, const JobStatus& status, const std::string& command_line) {
  const std::string text = OnFarm([&] { return farm.GetReport(status.id); });
  Json report = Json::parse(text, nullptr, false);
  if (!report.is_object())
    throw Error(ErrorKind::kCorrupt,
                "the report of " + status.id.value + " is not JSON; is the coordinator of another version?");
  return CompleteReport(std::move(report), {status.scene_path, command_line});
}

Json DeliverJob(FarmClient& farm, const JobStatus& status, const FollowOptions& options) {
  const Image image = OnFarm([&] { return farm.GetImage(status.id); });
  Json report = FetchReport(farm, status, options.command_line);
  report["farm_job"] = status.id.value;
  // The image is written whatever is wrong with what was asked for besides.
  Failures failures;
  failures.Try([&] {
    if (options.reference.empty()) return;
    const Image reference = ReadImageFile(options.reference);
    CheckReference(reference, options.reference, image.width, image.height);
    // What has been rendered is gone: only the end of the curve can still be measured.
    const Json metrics = MetricsToJson(Compare(image, reference));
    report["reference"] = metrics;
    if (report["points"].is_array() && !report["points"].empty()) report["points"].back()["reference"] = metrics;
  });
  RenderExtras extras;
  if (!options.state.empty()) {
    extras.files.push_back({"state", options.state, [&] {
                              WriteText(options.state, OnFarm([&] { return farm.GetGuide(status.id); }).Serialize());
                            }});
  }
  report["files"] = DeliverRender(OutputPaths::For(options.output), image, report, status.method, failures, extras);
  failures.Throw();
  return report;
}

ExitCode FollowJob(FarmClient& farm, const JobId& id, const FollowOptions& options) {
  StopToken stop;
  JobStatus status;
  {
    InterruptGuard guard(&stop, "watching no longer");
    ProgressLine progress(options.quiet);
    std::optional<InterimPictures> pictures;
    if (!options.output.empty()) pictures.emplace(OutputPaths::For(options.output), progress);
    std::string said;
    status = OnFarm([&] {
      return farm.Watch(
          id,
          [&](const JobStatus& at) {
            if (at.progress.passes > 0) {
              progress.Update(ProgressOf(at));
            } else if (!options.quiet) {
              SayWaiting(at, &said);
            }
            if (pictures && !Ended(at.phase))
              pictures->Update(at.progress.seconds, [&] { return FetchPicture(farm, at, options.command_line); });
            return true;
          },
          &stop);
    });
  }
  const bool interrupted = InterruptGuard::Interrupted() && !Ended(status.phase);
  if (interrupted) {
    std::fprintf(stderr, "%s goes on; follow it again with: lodestar watch %s, end it with: lodestar cancel %s\n",
                 id.value.c_str(), id.value.c_str(), id.value.c_str());
  }
  Json document = StatusToJson(status);
  if (!options.output.empty() && status.progress.passes > 0) {
    document = DeliverJob(farm, status, options);
    document["phase"] = JobPhaseName(status.phase);
  }
  if (options.json) {
    std::cout << DumpJson(document) << "\n";
  } else if (document.contains("files")) {
    std::cout << Summary(document);
  } else {
    std::cout << StatusLine(status) << "\n";
  }
  if (interrupted) return ExitCode::kInterrupted;
  if (status.phase == JobPhase::kDone) return ExitCode::kOk;
  std::string message = id.value + " " + JobPhaseName(status.phase);
  if (!status.error.empty()) message += ": " + status.error;
  for (const std::string& line : status.log) message += "\n  " + line;
  throw CommandError(ExitCode::kJobFailed, message);
}

}  // namespace lodestar
