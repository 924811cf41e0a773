// lodestar workers: who renders.
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/farm_session.h"
#include "client/values.h"
#include "core/learning/report_json.h"

namespace lodestar {

void AddWorkersCommand(CLI::App& app, Invocation& invocation) {
  struct Arguments {
    FarmAddress farm;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("workers", "List the farm's workers");
  AddFarmOption(*sub, arguments->farm);
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments] {
      const auto workers =
          OnFarm([&] { return FarmClient(arguments->farm.address, arguments->farm.options).Workers(); });
      nlohmann::json list = nlohmann::json::array();
      for (const WorkerStatus& worker : workers) {
        if (arguments->json) {
          list.push_back({{"worker", worker.id.value},
                          {"name", worker.name},
                          {"threads", worker.threads},
                          {"fingerprint", worker.fingerprint},
                          {"leases", worker.leases},
                          {"units", worker.units},
                          {"units_per_second", worker.units_per_second},
                          {"seconds_since_seen", worker.seconds_since_seen}});
        } else {
          std::printf("%-12s %-20s %3u threads  %2u leases  %8llu units  %7s units/s  seen %s s ago\n",
                      worker.id.value.c_str(), worker.name.c_str(), worker.threads, worker.leases,
                      static_cast<unsigned long long>(worker.units), FormatNumber(worker.units_per_second).c_str(),
                      FormatNumber(worker.seconds_since_seen).c_str());
        }
      }
      if (arguments->json) {
        std::cout << DumpJson({{"workers", list}}) << "\n";
      } else if (workers.empty()) {
        std::cout << "no workers; start one with: lodestar-worker --coordinator " << arguments->farm.address << "\n";
      }
      return ExitCode::kOk;
    };
  });
}

}  // namespace lodestar
