// lodestar image: a job's picture so far.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/delivery.h"
#include "client/farm_session.h"
#include "core/learning/report_json.h"

namespace lodestar {

void AddImageCommand(CLI::App& app, Invocation& invocation) {
  struct Arguments {
    FarmAddress farm;
    std::string job;
    FollowOptions follow;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("image", "Fetch a job's image so far");
  sub->add_option("job", arguments->job, "The job's id")->required()->type_name("JOB");
  AddFarmOption(*sub, arguments->farm);
  sub->add_option("-o,--output", arguments->follow.output,
                  "Image: .exr, .png or .pfm, with .png, .csv, .json and -error.png beside it [JOB.exr here]")
      ->type_name("FILE");
  sub->add_option("--reference", arguments->follow.reference, "Measure the image against this one")->type_name("FILE");
  AddStateOption(*sub, arguments->follow);
  sub->add_flag("--json", arguments->follow.json, "One JSON document on standard out");
  sub->footer(
      "Examples:\n"
      "  lodestar image job-17 -o out/door.exr\n"
      "  lodestar image job-17 -o out/door.exr --state out/door.lguide");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] {
      FollowOptions follow = arguments->follow;
      follow.command_line = command_line;
      FarmClient farm(arguments->farm.address, arguments->farm.options);
      const JobStatus status = OnFarm([&] { return farm.GetJob({arguments->job}); });
      if (follow.output.empty()) follow.output = status.id.value + ".exr";
      PrepareDelivery(follow);
      const nlohmann::json report = DeliverJob(farm, status, follow);
      std::cout << (follow.json ? DumpJson(report) + "\n" : Summary(report));
      return ExitCode::kOk;
    };
  });
}

}  // namespace lodestar
