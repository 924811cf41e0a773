// lodestar jobs: what the farm has to do and has done.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/farm_session.h"
#include "core/learning/report_json.h"

namespace lodestar {

void AddJobsCommand(CLI::App& app, Invocation& invocation) {
  struct Arguments {
    FarmAddress farm;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("jobs", "List the farm's jobs, newest first");
  AddFarmOption(*sub, arguments->farm);
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments] {
      const auto jobs = OnFarm([&] { return FarmClient(arguments->farm.address, arguments->farm.options).ListJobs(); });
      if (arguments->json) {
        nlohmann::json list = nlohmann::json::array();
        for (const JobStatus& job : jobs) list.push_back(StatusToJson(job));
        std::cout << DumpJson({{"jobs", list}}) << "\n";
      } else if (jobs.empty()) {
        std::cout << "no jobs\n";
      } else {
        for (const JobStatus& job : jobs) std::cout << StatusLine(job) << "\n";
      }
      return ExitCode::kOk;
    };
  });
}

}  // namespace lodestar
