#include "client/job_options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "client/command.h"
#include "client/suggest.h"
#include "client/values.h"
#include "core/scene/pbrt_parser.h"

namespace lodestar {
namespace {

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  for (const MethodEntry& method : Methods()) names.push_back(method.name);
  return names;
}

std::pair<std::string, std::string> SplitAssignment(const std::string& text, const std::string& where) {
  const size_t at = text.find('=');
  if (at == std::string::npos || at == 0) {
    throw Error(ErrorKind::kInvalidInput, where + ": '" + text + "' is not an option with its value; write NAME=VALUE");
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

std::string MethodList() {
  std::string text;
  for (const MethodEntry& method : Methods()) text += (text.empty() ? "" : "; ") + method.name + ": " + method.summary;
  return text;
}

// One flag for each option of any method; methods that share a name share its flag. A name that is taken by an option
// of ours gets the method's in front: --sdtree-max-depth.
void AddMethodFlags(CLI::App& app, JobArguments& arguments) {
  std::set<std::string> taken;
  for (const CLI::Option* option : app.get_options())
    taken.insert(option->get_lnames().begin(), option->get_lnames().end());
  struct Flag {
    std::string option, owners, values, help;
  };
  std::map<std::string, Flag> flags;
  for (const MethodEntry& method : Methods()) {
    for (const OptionHelp& option : method.options) {
      Flag& flag = flags[taken.contains(option.name) ? method.name + "-" + option.name : option.name];
      const bool shared = !flag.owners.empty();
      flag.option = option.name;
      flag.owners += (shared ? ", " : "") + method.name;
      if (!shared) flag.values = option.values;
      flag.help += (shared ? ". " + method.name + " (" + option.values + "): " : "") + option.help + " [" +
                   option.default_value + "]";
    }
  }
  for (const auto& [name, flag] : flags) {
    app.add_option_function<std::string>(
           "--" + name,
           [&arguments, option = flag.option](const std::string& value) { arguments.flags[option] = value; }, flag.help)
        ->type_name(flag.values)
        ->group("Options of the method " + flag.owners);
  }
}

}  // namespace

const MethodEntry& FindMethod(const std::string& name) {
  for (const MethodEntry& method : Methods()) {
    if (method.name == name) return method;
  }
  throw Error(ErrorKind::kInvalidInput, "unknown method '" + name + "'" + Suggestion(name, MethodNames()) +
                                            " (there are: " + Join(MethodNames()) + ")");
}

bool TakesList(const MethodEntry& method, const std::string& name) {
  return std::ranges::any_of(method.options, [&](const OptionHelp& option) {
    return option.name == name && option.default_value.find(',') != std::string::npos;
  });
}

void CheckMethodOption(const MethodEntry& method, const std::string& name) {
  const auto has = [&](const MethodEntry& entry) {
    return std::ranges::any_of(entry.options, [&](const OptionHelp& option) { return option.name == name; });
  };
  if (has(method)) return;
  std::vector<std::string> names, others;
  for (const OptionHelp& option : method.options) names.push_back(option.name);
  for (const MethodEntry& entry : Methods()) {
    if (has(entry)) others.push_back(entry.name);
  }
  if (!others.empty()) {
    throw Error(ErrorKind::kInvalidInput,
                "method '" + method.name + "' has no option '" + name + "', but " +
                    (others.size() > 1 ? "these have it: " + Join(others) : others.front() + " has it") +
                    "; choose with --method");
  }
  throw Error(ErrorKind::kInvalidInput, "method '" + method.name + "' has no option '" + name + "'" +
                                            Suggestion(name, names) +
                                            (names.empty() ? " (it has none)" : " (it has: " + Join(names) + ")"));
}

MethodChoice ParseMethodChoice(const std::string& text) {
  MethodChoice choice;
  choice.label = text;
  const size_t colon = text.find(':');
  choice.method = text.substr(0, colon);
  const MethodEntry& method = FindMethod(choice.method);
  for (size_t at = colon; at != std::string::npos;) {
    const size_t next = text.find(',', at + 1);
    const auto [name, value] =
        SplitAssignment(text.substr(at + 1, next == std::string::npos ? next : next - at - 1), "method '" + text + "'");
    CheckMethodOption(method, name);
    std::string& chosen = choice.options[name] = value;
    if (TakesList(method, name)) std::ranges::replace(chosen, '/', ',');
    at = next;
  }
  return choice;
}

JobSpec JobArguments::ToJob() const {
  JobSpec job;
  job.method = method;
  const MethodEntry& entry = FindMethod(method);
  for (const auto& [name, value] : flags) {
    CheckMethodOption(entry, name);
    job.options[name] = value;
  }
  for (const std::string& text : assignments) {
    const auto [name, value] = SplitAssignment(text, "--option");
    CheckMethodOption(entry, name);
    job.options[name] = value;
  }
  job.budget.spp = spp;
  if (!time.empty()) job.budget.seconds = ParseDuration(time);
  if (!(error >= 0) || !std::isfinite(error))
    throw Error(ErrorKind::kInvalidInput, "--error must be a positive relMSE, e.g. 0.01");
  job.budget.error = error;
  job.seed = seed;
  if (!resolution.empty()) {
    const Resolution size = ParseResolution(resolution);
    job.resolution_x = size.x;
    job.resolution_y = size.y;
  }
  job.filter = filter;
  if (max_depth < 0) throw Error(ErrorKind::kInvalidInput, "--max-depth must be at least 1");
  job.max_depth = max_depth;
  job.training_iterations = training_iterations;
  job.lenient = lenient;
  return job;
}

void AddJobOptions(CLI::App& app, JobArguments& arguments, const JobOptionGroups& groups) {
  app.add_option("scene", arguments.scene, "The pbrt-v4 scene file")->required()->type_name("SCENE");
  if (groups.method) {
    app.add_option("--method", arguments.method, MethodList())->capture_default_str()->type_name("NAME");
    app.add_option("--option", arguments.assignments,
                   "An option of the method, as often as needed; each is a flag of its own too")
        ->type_name("NAME=VALUE")
        ->take_all();
    app.add_option("--training-iterations", arguments.training_iterations,
                   "Learn for that many iterations; a run by time or error reports its number, and a replay needs it "
                   "[-1: the method decides]")
        ->check(Unnamed(CLI::Range(-1, 1000)));
  }
  if (groups.budget) {
    app.add_option("--spp", arguments.spp,
                   "Stop at that many samples per pixel, training included [the scene's, without any budget]")
        ->check(AboveZero())
        ->group("Budget (the first one reached ends the run)");
    app.add_option("--time", arguments.time,
                   "Stop after this render time: 60s, 5m, 1h30m; loading and writing are not counted")
        ->type_name("DURATION")
        ->group("Budget (the first one reached ends the run)");
    app.add_option("--error", arguments.error,
                   "Stop at this estimated relMSE (worst 0.1 % of pixels left out), e.g. 0.01")
        ->check(AboveZero())
        ->group("Budget (the first one reached ends the run)");
  }
  app.add_option("--resolution", arguments.resolution, "Pixels of the image [the scene's]")->type_name("WxH");
  app.add_option("--filter", arguments.filter, "Pixel filter: box, triangle, gaussian, mitchell [the scene's]")
      ->check(Unnamed(CLI::IsMember({"box", "triangle", "gaussian", "mitchell"})))
      ->type_name("NAME");
  app.add_option("--max-depth", arguments.max_depth, "Longest path in surface interactions [the scene's]")
      ->check(Unnamed(CLI::Range(1, 1 << 20)));
  app.add_option("--seed", arguments.seed, "Seed of all random numbers; the same seed gives the same bits")
      ->capture_default_str()
      ->check(ZeroOrAbove());
  app.add_flag("--lenient", arguments.lenient,
               "Leave out and list what a scene has and Lodestar does not support, instead of refusing it");
  if (groups.method) AddMethodFlags(app, arguments);
}

SceneDescription LoadScene(const std::string& path, const ParseOptions& options) {
  try {
    SceneDescription description = ParsePbrtFile(path, options);
    if (!description.left_out.empty()) {
      std::fprintf(stderr, "left out (--lenient):\n");
      for (const std::string& line : description.left_out) std::fprintf(stderr, "  %s\n", line.c_str());
    }
    return description;
  } catch (const Error& error) {
    throw CommandError(ExitCode::kBadScene, error.what());
  }
}

}  // namespace lodestar
