// lodestar cancel: ends jobs of the farm; what they rendered stays.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/farm_session.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

struct CancelArguments {
  FarmAddress farm;
  std::vector<std::string> jobs;
  bool json = false;
};

ExitCode Cancel(const CancelArguments& arguments) {
  FarmClient farm(arguments.farm.address, arguments.farm.options);
  std::vector<std::string> cancelled, ended;
  std::string refused;  // keeps no other job from being cancelled
  for (const std::string& job : arguments.jobs) {
    try {
      OnFarm([&] { farm.Cancel({job}); });
      const JobPhase phase = OnFarm([&] { return farm.GetJob({job}); }).phase;
      const bool too_late = phase == JobPhase::kDone || phase == JobPhase::kFailed;
      (too_late ? ended : cancelled).push_back(job);
      if (!arguments.json)
        std::cout << (too_late ? job + " had ended before: " + JobPhaseName(phase) : "cancelled " + job) << "\n";
    } catch (const CommandError& error) {
      if (error.code() != ExitCode::kJobFailed) throw;
      refused += (refused.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  if (arguments.json) std::cout << DumpJson({{"cancelled", cancelled}, {"ended", ended}}) << "\n";
  if (!refused.empty()) throw CommandError(ExitCode::kJobFailed, refused);
  return ExitCode::kOk;
}

}  // namespace

void AddCancelCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<CancelArguments>();
  CLI::App* sub = app.add_subcommand("cancel", "End jobs; what they have rendered stays");
  sub->add_option("job", arguments->jobs, "Ids of jobs")->required()->type_name("JOB...");
  AddFarmOption(*sub, arguments->farm);
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->callback([arguments, &invocation] { invocation.run = [arguments] { return Cancel(*arguments); }; });
}

}  // namespace lodestar
