// lodestar watch: follows a job of the farm to its end.
#include <memory>

#include "client/command.h"
#include "client/farm_session.h"

namespace lodestar {

void AddWatchCommand(CLI::App& app, Invocation& invocation) {
  struct Arguments {
    FarmAddress farm;
    std::string job;
    FollowOptions follow;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("watch", "Follow a job until it ends");
  sub->add_option("job", arguments->job, "The job's id")->required()->type_name("JOB");
  AddFarmOption(*sub, arguments->farm);
  sub->add_option("-o,--output", arguments->follow.output,
                  "Write the image and its .png now and then and at the end, and then .csv, .json and -error.png")
      ->type_name("FILE");
  sub->add_option("--reference", arguments->follow.reference, "With -o: measure the final image against this one")
      ->type_name("FILE");
  AddStateOption(*sub, arguments->follow);
  sub->add_flag("--json", arguments->follow.json, "One JSON document on standard out, at the end");
  sub->add_flag("--quiet", arguments->follow.quiet, "No progress on standard error");
  sub->footer("Example:\n  lodestar watch job-17 -o out/door.exr\nCtrl-C ends the watching, not the job.");
  sub->callback([arguments, &invocation] {
    invocation.run = [arguments, command_line = invocation.command_line] {
      FollowOptions follow = arguments->follow;
      follow.command_line = command_line;
      PrepareDelivery(follow);
      FarmClient farm(arguments->farm.address, arguments->farm.options);
      return FollowJob(farm, {arguments->job}, follow);
    };
  });
}

}  // namespace lodestar
