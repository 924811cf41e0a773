// What the farm's commands share: the address, the exit codes of its refusals, and following a job.
#pragma once

#include <CLI/App.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "client/exit_code.h"
#include "client/outputs.h"
#include "core/learning/loop.h"
#include "rpc/farm_client.h"

namespace lodestar {

struct FarmAddress {
  std::string address = "localhost:7420";
  FarmClient::Options options;
};
// --farm HOST:PORT (or LODESTAR_FARM) and --retry.
void AddFarmOption(CLI::App& app, FarmAddress& farm);

// Runs a call to the farm; an unreachable one becomes CommandError(kFarmUnreachable), a refusal
// CommandError(kJobFailed).
[[noreturn]] void ThrowFarmError(const Error& error);
template <class Call>
auto OnFarm(const Call& call) {
  try {
    return call();
  } catch (const Error& error) {
    ThrowFarmError(error);
  }
}

JobProgress ProgressOf(const JobStatus& status);
nlohmann::json StatusToJson(const JobStatus& status);
// "job-17  running  42%  sdtree  128 spp  error 0.0123  0:31 left  door-ajar"
std::string StatusLine(const JobStatus& status);

struct FollowOptions {
  std::string output;     // image to write now and then, and when the job or the watching ends; "": none
  std::string reference;  // measure the final image against this; "": none
  std::string state;      // with output: what was learned goes here; "": nowhere
  std::string command_line;
  bool json = false, quiet = false;
};
// --state of the commands that fetch a job's image.
void AddStateOption(CLI::App& app, FollowOptions& options);
// Makes the folders of what will be written; refuses --state without an image. Throws Error.
void PrepareDelivery(const FollowOptions& options);

// Shows progress and writes the picture so far until the job ends or Ctrl-C (which leaves the job running), then
// delivers its files. kJobFailed for a failed or cancelled job.
ExitCode FollowJob(FarmClient& farm, const JobId& id, const FollowOptions& options);

// The job's report, completed (delivery.h). Throws Error(kCorrupt) where it is not JSON.
nlohmann::json FetchReport(FarmClient& farm, const JobStatus& status, const std::string& command_line);
// Fetches image and report and writes the files of OutputPaths; gives back the completed report. Throws, once all that
// can be is written, where the reference does not fit, there is no state, or a file could not be written.
nlohmann::json DeliverJob(FarmClient& farm, const JobStatus& status, const FollowOptions& options);

}  // namespace lodestar
