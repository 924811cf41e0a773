// lodestar report: a job's report and its error points, without the image.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/delivery.h"
#include "client/farm_session.h"
#include "core/learning/report_json.h"

namespace lodestar {

void AddReportCommand(CLI::App& app, Invocation& invocation) {
  struct Arguments {
    FarmAddress farm;
    std::string job;
    bool json = false, csv = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("report", "Show a job's report: time, rays, health, error against time");
  sub->add_option("job", arguments->job, "The job's id")->required()->type_name("JOB");
  AddFarmOption(*sub, arguments->farm);
  auto* json = sub->add_flag("--json", arguments->json, "The whole report as one JSON document on standard out");
  sub->add_flag("--csv", arguments->csv, "The error points as CSV on standard out")->excludes(json);
  sub->footer("Example:\n  lodestar report job-17 --csv > door.csv");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] {
      FarmClient farm(arguments->farm.address, arguments->farm.options);
      const JobStatus status = OnFarm([&] { return farm.GetJob({arguments->job}); });
      const nlohmann::json report = FetchReport(farm, status, command_line);
      if (arguments->json) {
        std::cout << DumpJson(report) << "\n";
      } else if (arguments->csv) {
        const auto seed = report.value("/job/seed"_json_pointer, uint64_t{0});
        std::cout << kCsvHeader
                  << PointsToCsv(status.method, seed, PointsFromJson(report.value("points", nlohmann::json::array())));
      } else {
        std::cout << StatusLine(status) << "\n" << Summary(report);
      }
      return ExitCode::kOk;
    };
  });
}

}  // namespace lodestar
