#include "core/learning/method.h"

#include "core/base/error.h"
#include "core/learning/auto_method.h"
#include "core/learning/focal_guiding.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/method_maker.h"
#include "core/learning/mixed_guiding.h"
#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"

namespace lodestar {
namespace {

struct Registered {
  MethodEntry entry;
  std::unique_ptr<Method> (*make)(const JobSpec&, const Survey&);
};

// One line a method.
const std::vector<Registered>& Registry() {
  static const std::vector<Registered> kRegistry = {
      {PathMethod::Entry(), Make<PathMethod>},   {SdTreeMethod::Entry(), Make<SdTreeMethod>},
      {FocalMethod::Entry(), Make<FocalMethod>}, {GridMethod::Entry(), Make<GridMethod>},
      {MixedMethod::Entry(), Make<MixedMethod>}, {AutoMethod::Entry(), Make<AutoMethod>},
  };
  return kRegistry;
}

}  // namespace

void AddStatistics(const Method& method, const std::shared_ptr<const State>& state, std::string_view bytes,
                   std::unique_ptr<Statistics>* sum) {
  if (!*sum) *sum = method.NewStatistics(state);
  if (!*sum) {
    throw Error(ErrorKind::kCorrupt,
                "statistics arrived for method '" + std::string(method.name()) + "', which learns nothing");
  }
  (*sum)->MergeSerialized(bytes);
}

std::span<const MethodEntry> Methods() {
  static const std::vector<MethodEntry> kEntries = [] {
    std::vector<MethodEntry> entries;
    for (const Registered& registered : Registry()) entries.push_back(registered.entry);
    return entries;
  }();
  return kEntries;
}

std::unique_ptr<Method> MakeMethod(const JobSpec& job, const Survey& survey) {
  std::string names;
  for (const Registered& registered : Registry()) {
    if (registered.entry.name == job.method) return registered.make(job, survey);
    names += (names.empty() ? "" : ", ") + registered.entry.name;
  }
  throw Error(ErrorKind::kInvalidInput, "there is no method '" + job.method + "'; there are: " + names);
}

}  // namespace lodestar
