// What each value of each option of SD-tree guiding sets.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "core/learning/sd_tree_guiding.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

using Options = SdTreeMethod::Options;
using Tree = SdTreeOptions;
using Learn = SdTreeMethod::Learn;
using Combination = Method::Combination;

Options Parse(std::map<std::string, std::string> given) {
  JobSpec job;
  job.method = "sdtree";
  job.options = std::move(given);
  return SdTreeMethod(job, test::SyntheticSurvey()).options();
}

// All of them: a new one does not compile until it is here.
auto Fields(const Options& options) {
  const auto& [tree, nee, learn, learn_lights, product, roulette, combination, training] = options;
  return std::tie(tree, nee, learn, learn_lights, product, roulette, combination, training);
}

TEST(SdTreePresets, AreOursAndThePapers) {
  EXPECT_TRUE(Fields(Parse({})) == Fields({.tree = Tree::Recommended(),
                                           .nee = NeeMode::kLearned,
                                           .learn = Learn::kWeighted,
                                           .learn_lights = true,
                                           .product = false,
                                           .roulette = Roulette::kPixel,
                                           .combination = Combination::kInverseVariance,
                                           .training = -1}));
  EXPECT_TRUE(Fields(Parse({{"preset", "default"}})) == Fields(Parse({})));
  EXPECT_TRUE(Fields(Parse({{"preset", "2017"}})) == Fields({.tree = Tree::Paper2017(),
                                                             .nee = NeeMode::kNever,
                                                             .learn = Learn::kWeighted,
                                                             .learn_lights = false,
                                                             .product = false,
                                                             .roulette = Roulette::kThroughput,
                                                             .combination = Combination::kAutomatic,
                                                             .training = -1}));
  EXPECT_TRUE(Fields(Parse({{"preset", "2019"}})) == Fields({.tree = Tree::Paper2019(),
                                                             .nee = NeeMode::kKickstart,
                                                             .learn = Learn::kWeighted,
                                                             .learn_lights = false,
                                                             .product = false,
                                                             .roulette = Roulette::kThroughput,
                                                             .combination = Combination::kInverseVariance,
                                                             .training = -1}));
}

using Change = std::function<void(Options&)>;

template <class T>
Change Of(T Options::*field, T value) {
  return [=](Options& options) { options.*field = value; };
}
template <class T>
Change Of(T Tree::*field, T value) {
  return [=](Options& options) { options.tree.*field = value; };
}
Change Both(const Change& first, const Change& second) {
  return [=](Options& options) {
    first(options);
    second(options);
  };
}

struct Setting {
  std::string option, value;
  Change change;
};

std::vector<Setting> Settings() {
  const auto nee = [](NeeMode mode, bool learned) {
    return Both(Of(&Options::nee, mode), Of(&Tree::learn_nee, learned));
  };
  const auto fraction = [](Tree::BsdfFractionLoss loss) { return Of(&Tree::bsdf_fraction_loss, loss); };
  return {
      {"nee", "never", nee(NeeMode::kNever, false)},
      {"nee", "kickstart", nee(NeeMode::kKickstart, false)},
      {"nee", "always", nee(NeeMode::kAlways, false)},
      {"nee", "learned", nee(NeeMode::kLearned, true)},
      {"lights", "power", Of(&Options::learn_lights, false)},
      {"lights", "learned", Of(&Options::learn_lights, true)},
      {"target", "radiance", Of(&Tree::target, Tree::Target::kRadiance)},
      {"target", "simple", Of(&Tree::target, Tree::Target::kSimple)},
      {"target", "full", Of(&Tree::target, Tree::Target::kFull)},
      {"target", "switching", Of(&Tree::target, Tree::Target::kSwitching)},
      {"reconstruction", "none", Of(&Tree::reconstruction, Tree::Reconstruction::kNone)},
      {"reconstruction", "dense", Of(&Tree::reconstruction, Tree::Reconstruction::kDense)},
      {"reconstruction", "dense-unlimited", Of(&Tree::reconstruction, Tree::Reconstruction::kDenseUnlimited)},
      {"reconstruction", "native", Of(&Tree::reconstruction, Tree::Reconstruction::kNative)},
      {"dense-sigma", "0.1", Of(&Tree::dense_sigma, 0.1f)},
      {"dense-sigma", "3", Of(&Tree::dense_sigma, 3.0f)},
      // A product is of radiance.
      {"product", "on", Both(Of(&Options::product, true), Of(&Tree::target, Tree::Target::kRadiance))},
      {"product", "off", Of(&Options::product, false)},
      {"learn", "all", Of(&Options::learn, Learn::kAll)},
      {"learn", "weighted", Of(&Options::learn, Learn::kWeighted)},
      {"learn", "indirect", Of(&Options::learn, Learn::kIndirect)},
      {"roulette", "throughput", Of(&Options::roulette, Roulette::kThroughput)},
      {"roulette", "contribution", Of(&Options::roulette, Roulette::kContribution)},
      {"roulette", "pixel", Of(&Options::roulette, Roulette::kPixel)},
      {"combine", "discard", Of(&Options::combination, Combination::kDiscard)},
      {"combine", "automatic", Of(&Options::combination, Combination::kAutomatic)},
      {"combine", "inverse-variance", Of(&Options::combination, Combination::kInverseVariance)},
      {"spatial-filter", "nearest", Of(&Tree::spatial_filter, Tree::SpatialFilter::kNearest)},
      {"spatial-filter", "stochastic", Of(&Tree::spatial_filter, Tree::SpatialFilter::kStochastic)},
      {"spatial-filter", "box", Of(&Tree::spatial_filter, Tree::SpatialFilter::kBox)},
      {"directional-filter", "nearest", Of(&Tree::directional_filter, Tree::DirectionalFilter::kNearest)},
      {"directional-filter", "box", Of(&Tree::directional_filter, Tree::DirectionalFilter::kBox)},
      {"bsdf-fraction", "learned-kl", fraction(Tree::BsdfFractionLoss::kKl)},
      {"bsdf-fraction", "learned-variance", fraction(Tree::BsdfFractionLoss::kVariance)},
      {"bsdf-fraction", "0.25", Both(fraction(Tree::BsdfFractionLoss::kNone), Of(&Tree::initial_bsdf_fraction, 0.25f))},
      {"spatial-threshold", "2e3", Of(&Tree::spatial_threshold, 2000.0f)},
      {"flux-threshold", "0.02", Of(&Tree::flux_threshold, 0.02f)},
      {"max-depth", "12", Of(&Tree::max_directional_depth, 12)},
      {"training", "auto", Of(&Options::training, -1)},
      {"training", "0", Of(&Options::training, 0)},
      {"training", "5", Of(&Options::training, 5)},
  };
}

TEST(SdTreeOption, SetsItsFieldAndNoOther) {
  for (const char* preset : {"default", "2017", "2019"})
    for (const auto& [option, value, change] : Settings()) {
      Options expected = Parse({{"preset", preset}});
      change(expected);
      EXPECT_TRUE(Fields(Parse({{"preset", preset}, {option, value}})) == Fields(expected))
          << preset << " " << option << "=" << value;
    }
}

TEST(SdTreeOption, IsLookedAtInEveryDocumentedValue) {
  std::map<std::string, std::set<std::string>> values;
  for (const Setting& setting : Settings()) values[setting.option].insert(setting.value);
  const MethodEntry entry = SdTreeMethod::Entry();
  for (const OptionHelp& option : entry.options)
    if (option.name != "preset") {
      EXPECT_GE(values[option.name].size(), 1u + static_cast<size_t>(std::ranges::count(option.values, '|')))
          << option.name << ": " << option.values;
    }
}

}  // namespace
}  // namespace lodestar
