#include "core/learning/sd_tree_guiding.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/guiding/sd_tree_advance.h"
#include "core/learning/method_options.h"

namespace lodestar {
namespace {

const SdTreeState& AsSdTree(const std::shared_ptr<const State>& state) {
  const auto* cast = dynamic_cast<const SdTreeState*>(state.get());
  LODESTAR_CHECK(cast != nullptr);
  return *cast;
}

// The papers' settings; NEE and combination of 2017 are those of its main results (no light sampling, automatic).
SdTreeMethod::Options Preset(const MethodOptions& given) {
  using Kind = Method::Combination::Kind;
  enum class Name { kDefault, k2017, k2019 };
  SdTreeMethod::Options options;
  switch (given.Choice<Name>("preset", {{"default", Name::kDefault}, {"2017", Name::k2017}, {"2019", Name::k2019}})) {
    case Name::k2017:
      options.tree = SdTreeOptions::Paper2017();
      options.nee = NeeMode::kNever;
      options.combination.kind = Kind::kAutomatic;
      break;
    case Name::k2019:
      options.tree = SdTreeOptions::Paper2019();
      options.nee = NeeMode::kKickstart;
      break;
    case Name::kDefault:
      break;
  }
  return options;
}

void ReadBsdfFraction(const MethodOptions& given, SdTreeOptions* tree) {
  using Loss = SdTreeOptions::BsdfFractionLoss;
  const std::string& text = given.Text("bsdf-fraction");
  if (text == "learned-kl" || text == "learned-variance") {
    tree->bsdf_fraction_loss = text == "learned-kl" ? Loss::kKl : Loss::kVariance;
  } else {
    tree->bsdf_fraction_loss = Loss::kNone;
    tree->initial_bsdf_fraction = static_cast<float>(given.Number("bsdf-fraction", 0.05, 0.95));
  }
}

}  // namespace

MethodEntry SdTreeMethod::Entry() {
  const std::string preset = "the preset's";
  return {"sdtree",
          "path tracing guided by a learned SD-tree (Mueller et al. 2017, 2019)",
          {
              {"preset", "default | 2017 | 2019", "default",
               "starting values of the other options: ours (recommended), or those of the papers, for comparisons"},
              {"nee", "never | kickstart | always", preset,
               "next event estimation; kickstart: in the first three iterations only. Default always; 2017 never, 2019 "
               "kickstart. Recommended: "
               "always, unless no light can be seen from where most paths go"},
              {"combine", "discard | automatic | inverse-variance", preset,
               "how iterations become the image: the longest alone; the same, and training stops once the predicted "
               "final variance stops falling; the "
               "last four by their variance. Default and 2019 inverse-variance (recommended), 2017 automatic; discard "
               "is strictly unbiased"},
              {"spatial-filter", "nearest | stochastic | box", preset,
               "which spatial leaves a record goes to. Default and 2019 stochastic (recommended), 2017 nearest; box is "
               "smoothest and slowest"},
              {"directional-filter", "nearest | box", preset,
               "the same for directions. Default and 2019 box (recommended), 2017 nearest"},
              {"bsdf-fraction", "learned-kl | learned-variance | a number from 0.05 to 0.95", preset,
               "share of directions that the BSDF samples: learned per leaf, or fixed. Default and 2019 learned-kl "
               "(recommended), 2017 0.5; "
               "learned-variance is optimal in theory and suffers from outliers"},
              {"spatial-threshold", "a number from 1 to 1e12", preset,
               "c: a spatial leaf splits above c * sqrt(passes / 4) records. Default and 2019 4000, 2017 12000; less "
               "for long renders of intricate light"},
              {"flux-threshold", "a number from 1e-5 to 1", preset,
               "a directional cell splits above this share of its tree's flux. Default and papers 0.01"},
              {"max-depth", "an integer from 1 to 20", preset, "levels of a directional tree. Default and papers 20"},
              {"training", "auto | a number of iterations from 0 to 30", "auto",
               "iterations to learn in before the last one, which only renders; iteration k has 2^k passes. auto "
               "(recommended): as many as leave "
               "at least half of the budget to the last"},
          }};
}

SdTreeMethod::SdTreeMethod(const JobSpec& job, const Survey& survey) : bounds_(survey.bounds) {
  using Kind = Combination::Kind;
  using Tree = SdTreeOptions;
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  options_ = Preset(given);
  Tree& tree = options_.tree;
  if (given.Has("nee")) {
    options_.nee = given.Choice<NeeMode>(
        "nee", {{"never", NeeMode::kNever}, {"kickstart", NeeMode::kKickstart}, {"always", NeeMode::kAlways}});
  }
  if (given.Has("combine")) {
    options_.combination.kind = given.Choice<Kind>(
        "combine",
        {{"discard", Kind::kDiscard}, {"automatic", Kind::kAutomatic}, {"inverse-variance", Kind::kInverseVariance}});
  }
  if (given.Has("spatial-filter")) {
    tree.spatial_filter =
        given.Choice<Tree::SpatialFilter>("spatial-filter", {{"nearest", Tree::SpatialFilter::kNearest},
                                                             {"stochastic", Tree::SpatialFilter::kStochastic},
                                                             {"box", Tree::SpatialFilter::kBox}});
  }
  if (given.Has("directional-filter")) {
    tree.directional_filter = given.Choice<Tree::DirectionalFilter>(
        "directional-filter", {{"nearest", Tree::DirectionalFilter::kNearest}, {"box", Tree::DirectionalFilter::kBox}});
  }
  if (given.Has("bsdf-fraction")) ReadBsdfFraction(given, &tree);
  if (given.Has("spatial-threshold"))
    tree.spatial_threshold = static_cast<float>(given.Number("spatial-threshold", 1, 1e12));
  if (given.Has("flux-threshold")) tree.flux_threshold = static_cast<float>(given.Number("flux-threshold", 1e-5, 1));
  if (given.Has("max-depth")) tree.max_directional_depth = given.Integer("max-depth", 1, 20);
  if (given.Text("training") != "auto") options_.training = given.Integer("training", 0, 30);
  tree.Validate();
}

void SdTreeGuidingStatistics::Merge(const Statistics& other) {
  const auto* cast = dynamic_cast<const SdTreeGuidingStatistics*>(&other);
  LODESTAR_CHECK(cast != nullptr);
  sums_.Merge(cast->sums_);
}

std::shared_ptr<const State> SdTreeMethod::Initial() const {
  return std::make_shared<SdTreeState>(SdTree::Initial(bounds_, options_.tree));
}

std::shared_ptr<const State> SdTreeMethod::ParseState(std::string_view bytes) const {
  return std::make_shared<SdTreeState>(SdTree::Parse(bytes));
}

std::unique_ptr<Statistics> SdTreeMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  return std::make_unique<SdTreeGuidingStatistics>(SdTreeStatistics(AsSdTree(state).shared_tree()));
}

std::unique_ptr<Statistics> SdTreeMethod::ParseStatistics(const std::shared_ptr<const State>& state,
                                                          std::string_view bytes) const {
  return std::make_unique<SdTreeGuidingStatistics>(SdTreeStatistics::Parse(AsSdTree(state).shared_tree(), bytes));
}

std::shared_ptr<const State> SdTreeMethod::Advance(const std::shared_ptr<const State>& state,
                                                   const IterationResult& result) const {
  if (result.statistics == nullptr) return state;
  const auto* learned = dynamic_cast<const SdTreeGuidingStatistics*>(result.statistics);
  LODESTAR_CHECK(learned != nullptr);
  return std::make_shared<SdTreeState>(
      lodestar::Advance(AsSdTree(state).tree(), learned->sums(), static_cast<double>(result.passes)));
}

}  // namespace lodestar
