// The options that say what to render, shared by render, submit, replay and compare, and the direct flags of every
// method's options, generated from the method registry.
#pragma once

#include <CLI/App.hpp>
#include <map>
#include <string>
#include <vector>

#include "core/learning/job.h"
#include "core/learning/method.h"
#include "core/scene/pbrt_parser.h"

namespace lodestar {

struct JobArguments {
  std::string scene;
  std::string method = JobSpec().method;
  std::string time, resolution, filter;
  uint64_t spp = 0, seed = 0;
  double error = 0;
  int max_depth = 0, training_iterations = -1;
  bool lenient = false;
  std::vector<std::string> assignments;      // --option NAME=VALUE
  std::map<std::string, std::string> flags;  // --NAME VALUE of the registry's options, where given

  // Throws Error(kInvalidInput) for a value out of its range, an unknown method or an option that the method does not
  // take.
  JobSpec ToJob() const;
};

// Which groups of options a subcommand takes.
struct JobOptionGroups {
  bool method = true;  // --method, --option and the direct flags
  bool budget = true;  // --spp, --time, --error
};
void AddJobOptions(CLI::App& app, JobArguments& arguments, const JobOptionGroups& groups = {});

// "sdtree:nee=always,combine=discard": a method and options of it, as compare takes them. The values of a list, which
// --option parts by commas, are parted by slashes: "auto:candidates=path/sdtree".
struct MethodChoice {
  std::string label;  // as written
  std::string method;
  std::map<std::string, std::string> options;
};
MethodChoice ParseMethodChoice(const std::string& text);

const MethodEntry& FindMethod(const std::string& name);
// True where the value of an option may be a list, as its default is.
bool TakesList(const MethodEntry& method, const std::string& option);
// Throws Error(kInvalidInput) listing the method's options where `name` is none of them.
void CheckMethodOption(const MethodEntry& method, const std::string& name);

// Parses the scene, says on standard error what was left out, and turns its errors into CommandError(kBadScene).
SceneDescription LoadScene(const std::string& path, const ParseOptions& options);

}  // namespace lodestar
