#include "core/learning/focal_guiding.h"

#include <algorithm>
#include <bit>

#include "core/guiding/focal_advance.h"
#include "core/learning/method_options.h"

namespace lodestar {
namespace {

// Paths that an iteration traces where its passes are not given: enough for the masses of a thousand voxels.
constexpr uint64_t kPathsPerIteration = uint64_t{1} << 18;

// Together, training iterations take at most half of the samples per pixel that were asked for. Where that is less than
// one pass each, the loop ends training early.
uint64_t AutomaticPasses(const JobSpec& job, const Survey& survey, uint32_t iterations) {
  uint64_t passes = std::bit_floor(std::clamp<uint64_t>(kPathsPerIteration / survey.pixels(), 1, 64));
  if (job.budget.spp > 0) passes = std::min(passes, std::max<uint64_t>(1, job.budget.spp / (2 * uint64_t{iterations})));
  return passes;
}

}  // namespace

MethodEntry FocalMethod::Entry() {
  return {"focal",
          "path tracing guided towards the places where light converges (Rath et al. 2023)",
          {
              {"nee", "never | always", "always",
               "next event estimation. Recommended: always, unless no light can be seen from where most paths go"},
              {"combine", "discard | inverse-variance", "inverse-variance",
               "how iterations become the image: the last alone, which is strictly unbiased, or all by their variance "
               "(recommended)"},
              {"initial-iterations", "an integer from 1 to 30", "6",
               "training iterations that spread a path's light along its segments. The document's value"},
              {"narrowing-iterations", "an integer from 0 to 30", "6",
               "those that concentrate it and deepen the octree, a level each. The document's value; 10 for pinholes"},
              {"narrow-factor", "a number from 0.25 to 8", "1",
               "power of a voxel's share when it concentrates: more is quicker and less steady. The document's value"},
              {"narrow-by", "mixture | guide", "mixture",
               "what narrowing iterations learn from: the share of a path's light that the guide alone accounts for "
               "(recommended), or all of it (Sadek's document)"},
              {"split-threshold", "a number from 1e-5 to 1", "0.001",
               "a voxel splits above this share of all light. The document's value; less is sharper and slower"},
              {"prune-ratio", "a number from 0 to 1e6", "2",
               "after training, subtrees without a leaf denser than this times their mean collapse; 0: none"},
              {"decay", "a number from 0 to 1", "0.5", "weight of earlier iterations after each. The document's value"},
              {"start-depth", "an integer from 1 to 6", "3", "levels of the octree to begin with"},
              {"images", "on | off", "on",
               "look for virtual images behind mirrors and lenses smoother than roughness 0.3, too"},
              {"diverging", "on | off", "off",
               "look for places that light seems to come from behind the surface it falls on, too, in a second octree"},
              {"bsdf-fraction", "learned | a number from 0.05 to 0.95", "0.5",
               "share of directions that the BSDF samples: fixed, or learned per cell of a coarse grid"},
              {"passes", "auto | an integer from 1 to 4096", "auto",
               "passes of a training iteration. auto: a quarter of a million paths, and no more than half of the "
               "samples per pixel that were asked for in all training"},
          }};
}

FocalMethod::FocalMethod(const JobSpec& job, const Survey& survey) : bounds_(survey.bounds) {
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  FocalOptions& field = options_.field;
  options_.nee = given.Choice<NeeMode>("nee", {{"never", NeeMode::kNever}, {"always", NeeMode::kAlways}});
  options_.combination = given.Choice<Combination>(
      "combine", {{"discard", Combination::kDiscard}, {"inverse-variance", Combination::kInverseVariance}});
  field.initial_iterations = given.Integer("initial-iterations", 1, 30);
  field.narrowing_iterations = given.Integer("narrowing-iterations", 0, 30);
  field.narrow_factor = static_cast<float>(given.Number("narrow-factor", 0.25, 8));
  field.by_mixture = given.Choice<bool>("narrow-by", {{"mixture", true}, {"guide", false}});
  field.split_threshold = static_cast<float>(given.Number("split-threshold", 1e-5, 1));
  field.prune_ratio = static_cast<float>(given.Number("prune-ratio", 0, 1e6));
  field.decay = static_cast<float>(given.Number("decay", 0, 1));
  field.start_depth = given.Integer("start-depth", 1, 6);
  field.images = given.Choice<bool>("images", {{"on", true}, {"off", false}});
  field.diverging = given.Choice<bool>("diverging", {{"on", true}, {"off", false}});
  field.learn_fraction = given.Text("bsdf-fraction") == "learned";
  if (!field.learn_fraction) field.bsdf_fraction = static_cast<float>(given.Number("bsdf-fraction", 0.05, 0.95));
  field.Validate();
  options_.passes = given.Text("passes") == "auto" ? AutomaticPasses(job, survey, field.iterations())
                                                   : static_cast<uint64_t>(given.Integer("passes", 1, 4096));
}

std::shared_ptr<const State> FocalMethod::Initial() const {
  return std::make_shared<FocalState>(FocalField::Initial(bounds_, options_.field));
}

std::shared_ptr<const State> FocalMethod::ParseState(std::string_view bytes) const {
  auto field = FocalField::Parse(bytes);
  CheckOptions(field->options(), options_.field, "a focal guiding state");
  return std::make_shared<FocalState>(std::move(field));
}

std::unique_ptr<Statistics> FocalMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  return std::make_unique<FocalGuidingStatistics>(FocalStatistics(As<FocalState>(*state).shared_field()));
}

std::shared_ptr<const State> FocalMethod::Advance(const std::shared_ptr<const State>& state,
                                                  const IterationResult& result) const {
  const auto& focal = As<FocalState>(*state);
  // No unit recorded anything: the iteration is over all the same.
  if (result.statistics == nullptr)
    return std::make_shared<FocalState>(
        lodestar::Advance(focal.field(), FocalStatistics(focal.shared_field()), result.last));
  const auto& learned = As<FocalGuidingStatistics>(*result.statistics);
  return std::make_shared<FocalState>(lodestar::Advance(focal.field(), learned.sums(), result.last));
}

}  // namespace lodestar
