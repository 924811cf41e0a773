// The options of SD-tree guiding: their documentation, the presets, and reading them.
#include "core/learning/method_options.h"
#include "core/learning/sd_tree_guiding.h"

namespace lodestar {
namespace {

// The papers' settings; NEE and combination of 2017 are those of its main results (no light sampling, automatic).
SdTreeMethod::Options Preset(const MethodOptions& given) {
  enum class Name { kDefault, k2017, k2019 };
  SdTreeMethod::Options options;
  switch (given.Choice<Name>("preset", {{"default", Name::kDefault}, {"2017", Name::k2017}, {"2019", Name::k2019}})) {
    case Name::k2017:
      options.tree = SdTreeOptions::Paper2017();
      options.nee = NeeMode::kNever;
      options.learn_lights = false;
      options.roulette = Roulette::kThroughput;
      options.combination = Method::Combination::kAutomatic;
      break;
    case Name::k2019:
      options.tree = SdTreeOptions::Paper2019();
      options.nee = NeeMode::kKickstart;
      options.learn_lights = false;
      options.roulette = Roulette::kThroughput;
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
  return {
      "sdtree",
      "path tracing guided by a learned SD-tree (Mueller et al. 2017, 2019)",
      {
          {"preset", "default | 2017 | 2019", "default",
           "starting values of the other options: ours (recommended), or those of the papers, for comparisons"},
          {"nee", "never | kickstart | always | learned", preset,
           "next event estimation; kickstart: in the first three iterations only; learned: at the share of the "
           "vertices that lowers variance times cost most, found per leaf. Points, spots, distant and invisible lights "
           "are always sampled. Default learned (recommended); 2017 never, 2019 kickstart"},
          {"lights", "power | learned", preset,
           "which lights are sampled: by power; or by what arrives from them, in up to 32 groups, learned per leaf. "
           "Default learned (recommended), papers power"},
          {"target", "radiance | simple | full | switching", preset,
           "what the trees are proportional to: incident radiance; the root of the second moment of what a vertex "
           "reflects (Rath et al. 2020); the same relative to the pixel; simple first and full from the iteration of "
           "16 passes on (Nilsson 2023). Default switching (recommended); papers, and with a product, radiance"},
          {"reconstruction", "none | dense | dense-unlimited | native", preset,
           "smoothing of the trees: as the 2023 document does, on matrices, within its limit on the cost or without; "
           "or on the trees, with a strength found by cross-validation. Default native (recommended); papers none"},
          {"dense-sigma", "a number from 0.1 to 3", preset,
           "width of dense reconstruction's Gaussian, in cells of a layer. Default 0.5; up to 1 where trees are noisy"},
          {"product", "on | off", preset,
           "draw directions from the product of tree and BSDF (Diolatzis et al. 2020); for target radiance, as the "
           "others contain the BSDF. Default and papers off; less error a sample, at up to twice the time"},
          {"learn", "all | weighted | indirect", preset,
           "what a vertex records of a source that it meets and that its light samples find as well: all of it; its "
           "share by multiple importance sampling; nothing. Default and papers weighted"},
          {"roulette", "throughput | contribution | pixel", preset,
           "what decides on a path's survival: its throughput, as without guiding; what the tree expects it to add, "
           "against what its first vertex expects; the same against the pixel's estimate (ADRRS, Vorba and Krivanek "
           "2016, without splitting). Default pixel (recommended); 2017 and 2019 throughput"},
          {"combine", "discard | automatic | inverse-variance", preset,
           "how iterations become the image: the longest alone; the same, and training stops once the predicted "
           "final variance stops falling; all by their variance. Default and 2019 inverse-variance (recommended), 2017 "
           "automatic; discard is strictly unbiased"},
          {"spatial-filter", "nearest | stochastic | box", preset,
           "which spatial leaves a record goes to. Default and 2019 stochastic (recommended), 2017 nearest; box is "
           "smoothest and slowest"},
          {"directional-filter", "nearest | box", preset,
           "the same for directions. Default and 2019 box (recommended), 2017 nearest"},
          {"bsdf-fraction", "learned-kl | learned-variance | a number from 0.05 to 0.95", preset,
           "share of directions that the BSDF samples: learned per leaf, or fixed. Default and 2019 learned-kl "
           "(recommended), 2017 0.5; learned-variance is optimal in theory and suffers from outliers"},
          {"spatial-threshold", "a number from 1 to 1e12", preset,
           "c: a spatial leaf splits above c * sqrt(passes / 4) records. Default 700, 2019 4000, 2017 12000"},
          {"flux-threshold", "a number from 0.001 to 1", preset,
           "a directional cell splits above this share of its tree's flux. Default and papers 0.01"},
          {"max-depth", "an integer from 1 to 20", preset, "levels of a directional tree. Default and papers 20"},
          {"training", "auto | a number of iterations from 0 to 30", "auto",
           "iterations to learn in before the last one, which only renders; iteration k has 2^k passes. auto "
           "(recommended): as many as leave at least half of the budget to the last"},
      }};
}

SdTreeMethod::SdTreeMethod(const JobSpec& job, const Survey& survey)
    : bounds_(survey.bounds), resolution_x_(survey.resolution_x), resolution_y_(survey.resolution_y) {
  using Tree = SdTreeOptions;
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  options_ = Preset(given);
  Tree& tree = options_.tree;
  options_.nee = given.ChoiceOr("nee", options_.nee,
                                {{"never", NeeMode::kNever},
                                 {"kickstart", NeeMode::kKickstart},
                                 {"always", NeeMode::kAlways},
                                 {"learned", NeeMode::kLearned}});
  tree.learn_nee = options_.nee == NeeMode::kLearned;
  options_.learn_lights = given.ChoiceOr("lights", options_.learn_lights, {{"power", false}, {"learned", true}});
  if (options_.learn_lights) light_groups_ = survey.light_groups;
  tree.target = given.ChoiceOr("target", tree.target,
                               {{"radiance", Tree::Target::kRadiance},
                                {"simple", Tree::Target::kSimple},
                                {"full", Tree::Target::kFull},
                                {"switching", Tree::Target::kSwitching}});
  tree.reconstruction = given.ChoiceOr("reconstruction", tree.reconstruction,
                                       {{"none", Tree::Reconstruction::kNone},
                                        {"dense", Tree::Reconstruction::kDense},
                                        {"dense-unlimited", Tree::Reconstruction::kDenseUnlimited},
                                        {"native", Tree::Reconstruction::kNative}});
  tree.dense_sigma = static_cast<float>(given.NumberOr("dense-sigma", tree.dense_sigma, 0.1, 3));
  options_.product = given.ChoiceOr("product", options_.product, {{"on", true}, {"off", false}});
  if (options_.product && !given.Has("target")) tree.target = Tree::Target::kRadiance;
  if (options_.product && tree.target != Tree::Target::kRadiance) {
    throw Error(
        ErrorKind::kInvalidInput,
        "option 'product' of method 'sdtree' needs target=radiance: the other targets contain the BSDF already, "
        "which the product would count twice");
  }
  options_.learn = given.ChoiceOr(
      "learn", options_.learn, {{"all", Learn::kAll}, {"weighted", Learn::kWeighted}, {"indirect", Learn::kIndirect}});
  options_.roulette = given.ChoiceOr(
      "roulette", options_.roulette,
      {{"throughput", Roulette::kThroughput}, {"contribution", Roulette::kContribution}, {"pixel", Roulette::kPixel}});
  options_.combination = given.ChoiceOr("combine", options_.combination,
                                        {{"discard", Combination::kDiscard},
                                         {"automatic", Combination::kAutomatic},
                                         {"inverse-variance", Combination::kInverseVariance}});
  tree.spatial_filter = given.ChoiceOr("spatial-filter", tree.spatial_filter,
                                       {{"nearest", Tree::SpatialFilter::kNearest},
                                        {"stochastic", Tree::SpatialFilter::kStochastic},
                                        {"box", Tree::SpatialFilter::kBox}});
  tree.directional_filter =
      given.ChoiceOr("directional-filter", tree.directional_filter,
                     {{"nearest", Tree::DirectionalFilter::kNearest}, {"box", Tree::DirectionalFilter::kBox}});
  if (given.Has("bsdf-fraction")) ReadBsdfFraction(given, &tree);
  tree.spatial_threshold = static_cast<float>(given.NumberOr("spatial-threshold", tree.spatial_threshold, 1, 1e12));
  tree.flux_threshold = static_cast<float>(given.NumberOr("flux-threshold", tree.flux_threshold, 1e-3, 1));
  if (given.Has("max-depth")) tree.max_directional_depth = given.Integer("max-depth", 1, 20);
  if (given.Text("training") != "auto") options_.training = given.Integer("training", 0, 30);
  tree.Validate();
}

}  // namespace lodestar
