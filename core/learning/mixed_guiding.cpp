#include "core/learning/mixed_guiding.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/learning/method_options.h"

namespace lodestar {
namespace {

constexpr const char* kStateWhat = "state of method 'sdtree+focal'";
constexpr const char* kStatisticsWhat = "statistics of method 'sdtree+focal'";

// Of the tree all but its product with the BSDF, of focal guiding what makes the octree: the rest is the tree's to say.
bool OfTree(const std::string& name) {
  return name != "product";
}
bool OfFocal(const std::string& name) {
  return name != "nee" && name != "combine" && name != "bsdf-fraction" && name != "passes";
}

// What focal guiding does here unless it is told otherwise: four iterations to spread (18 passes less than six), and as
// many levels as a pinhole needs.
const std::map<std::string, std::string> kFocalDefaults = {
    {"initial-iterations", "4"}, {"narrowing-iterations", "10"}, {"bsdf-fraction", "learned"}};

// `job` with those of its options that `entry` has.
JobSpec Part(const JobSpec& job, const MethodEntry& entry, bool (*of)(const std::string&),
             std::map<std::string, std::string> options) {
  for (const OptionHelp& option : entry.options) {
    const auto given = job.options.find(option.name);
    if (of(option.name) && given != job.options.end()) options[option.name] = given->second;
  }
  JobSpec part = job;
  part.method = entry.name;
  part.options = std::move(options);
  return part;
}

// Throws Error(kInvalidInput) for options that neither part takes.
const JobSpec& Checked(const JobSpec& job) {
  const MethodEntry entry = MixedMethod::Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  return job;
}

}  // namespace

// ---- State and statistics: both parts', one after the other ----

Bytes MixedState::Serialize() const {
  ByteWriter out;
  out.PutString(tree_->Serialize());
  out.PutString(focal_->Serialize());
  return out.Take();
}

void MixedStatistics::Merge(const Statistics& other) {
  const auto& mixed = As<MixedStatistics>(other);
  tree_.Merge(mixed.tree_);
  focal_.Merge(mixed.focal_);
}

Bytes MixedStatistics::Serialize() const {
  ByteWriter out;
  out.PutString(tree_.Serialize());
  out.PutString(focal_.Serialize());
  return out.Take();
}

void MixedStatistics::MergeSerialized(std::string_view bytes) {
  ByteReader in(bytes, kStatisticsWhat);
  const auto tree = in.GetString();
  const auto focal = in.GetString();
  in.ExpectEnd();
  // Nothing has changed where either is refused. The focal ones are the smaller by far.
  FocalStatistics arrived(focal_.sums().field());
  arrived.MergeSerialized(focal);
  tree_.MergeSerialized(tree);
  focal_.sums().Merge(arrived);
}

void MixedStatistics::AddHealth(HealthReport* health) const {
  tree_.AddHealth(health);
  focal_.AddHealth(health);
}

// ---- The method ----

MethodEntry MixedMethod::Entry() {
  MethodEntry entry = {"sdtree+focal",
                       "path tracing guided by an SD-tree and by places where light converges, in one learned mixture",
                       {}};
  for (OptionHelp option : SdTreeMethod::Entry().options) {
    if (!OfTree(option.name)) continue;
    // Iterations have other lengths here.
    if (option.name == "target") option.help = "as for sdtree, but switching is full from the fifth iteration on";
    if (option.name == "training") option.help = "as for sdtree, but iteration k has about 2^(k/2) passes";
    entry.options.push_back(option);
  }
  for (OptionHelp option : FocalMethod::Entry().options) {
    if (!OfFocal(option.name)) continue;
    if (const auto own = kFocalDefaults.find(option.name); own != kFocalDefaults.end()) {
      option.default_value = own->second;
      option.help = option.help.substr(0, option.help.find(". The document's"));
    }
    entry.options.push_back(option);
  }
  return entry;
}

MixedMethod::MixedMethod(const JobSpec& job, const Survey& survey)
    : tree_(Part(Checked(job), SdTreeMethod::Entry(), OfTree, {}), survey),
      focal_(Part(job, FocalMethod::Entry(), OfFocal, kFocalDefaults), survey) {}

std::shared_ptr<const State> MixedMethod::Initial() const {
  return std::make_shared<MixedState>(std::dynamic_pointer_cast<const SdTreeState>(tree_.Initial()),
                                      std::dynamic_pointer_cast<const FocalState>(focal_.Initial()));
}

std::shared_ptr<const State> MixedMethod::ParseState(std::string_view bytes) const {
  ByteReader in(bytes, kStateWhat);
  const auto tree = in.GetString();
  const auto focal = in.GetString();
  in.ExpectEnd();
  return std::make_shared<MixedState>(std::dynamic_pointer_cast<const SdTreeState>(tree_.ParseState(tree)),
                                      std::dynamic_pointer_cast<const FocalState>(focal_.ParseState(focal)));
}

std::unique_ptr<Statistics> MixedMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  const auto& mixed = As<MixedState>(*state);
  return std::make_unique<MixedStatistics>(SdTreeStatistics(mixed.tree()->shared_tree()),
                                           FocalStatistics(mixed.focal()->shared_field()));
}

std::shared_ptr<const State> MixedMethod::Advance(const std::shared_ptr<const State>& state,
                                                  const IterationResult& result) const {
  const auto& mixed = As<MixedState>(*state);
  const auto* learned = result.statistics ? &As<MixedStatistics>(*result.statistics) : nullptr;
  IterationResult part = result;
  part.statistics = learned ? &learned->tree() : nullptr;
  const auto tree = tree_.Advance(mixed.tree(), part);
  part.statistics = learned ? &learned->focal() : nullptr;
  // The octree is done when it is; the tree goes on. And it does not begin before there is light to begin with: behind
  // a pinhole the first, short iterations hardly meet any.
  std::shared_ptr<const FocalState> focal = mixed.focal();
  if (focal->field().iteration() < focal->field().options().iterations()) {
    const auto next = std::dynamic_pointer_cast<const FocalState>(focal_.Advance(focal, part));
    if (next->field().HasLearned()) focal = next;
  }
  return std::make_shared<MixedState>(std::dynamic_pointer_cast<const SdTreeState>(tree), focal);
}

uint64_t MixedMethod::IterationPasses(const State&, uint32_t iteration) const {
  const uint64_t even = uint64_t{1} << std::min(iteration / 2, 32u);
  return iteration % 2 == 0 ? even : (even * 181 + 64) / 128;  // 181 / 128: the square root of two
}

}  // namespace lodestar
