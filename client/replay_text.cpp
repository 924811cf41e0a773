#include "client/replay_text.h"

#include <nlohmann/json.hpp>

#include "client/values.h"

namespace lodestar {

std::string ReplayCommand(const nlohmann::json& report, const std::string& scene_path) try {
  if (scene_path.empty() || !report.contains("/health/first"_json_pointer)) return "";
  const auto& first = report.at("health").at("first");
  const auto& job = report.at("job");
  const auto& scene = report.at("scene");
  const auto& result = report.at("result");
  std::string command =
      "lodestar replay " + ShellQuote(scene_path) + " --method " + job.at("method").get<std::string>();
  for (const auto& [name, value] : job.at("options").items())
    command += " --option " + ShellQuote(name + "=" + value.get<std::string>());
  if (const auto filter = job.at("filter").get<std::string>(); !filter.empty()) command += " --filter " + filter;
  if (job.value("lenient", false)) command += " --lenient";
  command += " --seed " + job.at("seed").dump();
  command += " --resolution " + scene.at("resolution").at(0).dump() + "x" + scene.at("resolution").at(1).dump();
  command += " --max-depth " + scene.at("max_depth").dump();
  // With these two as budget a job ends as the original did, however that was decided, so the states are the same.
  command += " --spp " + result.at("spp").dump() + " --training-iterations " + result.at("training_iterations").dump();
  command += " --pixel " + first.at("pixel").at(0).dump() + "," + first.at("pixel").at(1).dump();
  command += " --pass " + first.at("pass").dump() + " --iteration " + first.at("iteration").dump();
  return command;
} catch (const nlohmann::json::exception&) {
  return "";  // a report of another version
}

}  // namespace lodestar
