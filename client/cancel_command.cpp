// lodestar cancel: ends jobs of the farm; what they rendered stays.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/farm_session.h"
#include "core/learning/report_json.h"

namespace lodestar {

void AddCancelCommand(CLI::App& app, Invocation& invocation) {
  struct Arguments {
    FarmAddress farm;
    std::vector<std::string> jobs;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("cancel", "End jobs; what they have rendered stays");
  sub->add_option("job", arguments->jobs, "Ids of jobs")->required()->type_name("JOB...");
  AddFarmOption(*sub, arguments->farm);
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments] {
      FarmClient farm(arguments->farm.address, arguments->farm.options);
      for (const std::string& job : arguments->jobs) {
        OnFarm([&] { farm.Cancel({job}); });
        if (!arguments->json) std::cout << "cancelled " << job << "\n";
      }
      if (arguments->json) std::cout << DumpJson({{"cancelled", arguments->jobs}}) << "\n";
      return ExitCode::kOk;
    };
  });
}

}  // namespace lodestar
