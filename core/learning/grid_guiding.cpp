#include "core/learning/grid_guiding.h"

#include <algorithm>
#include <cstdio>

#include "core/guiding/grid_advance.h"
#include "core/guiding/grid_bias.h"
#include "core/learning/method_options.h"

namespace lodestar {
namespace {

using Sampling = GridRules::Sampling;

constexpr uint64_t kMostSteps = 16;     // where their number is not given
constexpr uint64_t kTrainingShare = 4;  // and the part of the samples per pixel that they may take, at most

uint32_t AutomaticSteps(const JobSpec& job, uint64_t batch) {
  if (job.budget.spp == 0) return kMostSteps;
  return static_cast<uint32_t>(std::clamp<uint64_t>(job.budget.spp / (kTrainingShare * batch), 1, kMostSteps));
}

}  // namespace

MethodEntry GridMethod::Entry() {
  return {
      "grid",
      "path tracing guided by a regular table of incident radiance (Kim 2022); diffuse-like surfaces only",
      {
          {"nee", "never | always", "always",
           "next event estimation. Recommended: always, unless no light can be seen from where most paths go"},
          {"combine", "discard | inverse-variance", "inverse-variance",
           "how iterations become the image: the last alone, which is strictly unbiased, or all by their variance "
           "(recommended)"},
          {"learn", "monte-carlo | sarsa | expected-sarsa", "expected-sarsa",
           "what the table learns from a path: what the rest of it brought; or the next hit's light and what the "
           "table says of its next direction (the document's choice); or of its whole hemisphere (recommended: here "
           "it costs no more)"},
          {"sampling",
           "inversion-sphere | inversion-hemisphere | rejection | rejection-mixed | metropolis | rejection-memo | "
           "rejection-mixed-memo",
           "inversion-hemisphere",
           "how directions are drawn. On the hemisphere (all but the first): times the cosine, none below the "
           "surface; by inversion recommended. rejection-mixed: the document's density; metropolis: research "
           "only, slow and blurred. -memo: normalised as in the document, BIASED, for comparison only"},
          {"mix", "document | a number from 0 to 1", "0.2",
           "share of even samples in rejection-mixed. document: by the acceptance rate, at most a half. Less is better "
           "here"},
          {"bsdf-fraction", "auto | a number from 0.05 to 0.95", "auto",
           "share of directions that the BSDF samples where it is diffuse. auto: a half"},
          {"cells", "an integer from 1 to 32", "8",
           "voxels of the table along each side of the scene. The document's value"},
          {"directions", "4 | 8 | 16 | 32", "16",
           "rows of directions in each voxel, twice as many columns. The document's value"},
          {"learning-rate", "a number from 1e-6 to 1", "0.02",
           "weight of a new record against all before it. Less is steadier and slower to forget"},
          {"prior", "a number from 0 to 1000", "10",
           "what the directions around say of an entry counts as this many records of its own; 0: nothing, as in "
           "the document"},
          {"exploration", "an integer from 1 to 1000, no more than steps", "1",
           "first steps that sample at random, by the BSDF. Where steps is auto, all of them at most"},
          {"batch", "an integer from 1 to 4096", "8", "passes between updates of the table. The document's value"},
          {"steps", "auto | an integer from 0 to 100000", "auto",
           "updates of the table. auto: 16, and no more than a quarter of the samples per pixel that were asked "
           "for"},
      }};
}

GridMethod::GridMethod(const JobSpec& job, const Survey& survey) : bounds_(survey.bounds) {
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  options_.nee = given.Choice<NeeMode>("nee", {{"never", NeeMode::kNever}, {"always", NeeMode::kAlways}});
  options_.combination = given.Choice<Combination>(
      "combine", {{"discard", Combination::kDiscard}, {"inverse-variance", Combination::kInverseVariance}});
  options_.learn = given.Choice<Learn>(
      "learn",
      {{"monte-carlo", Learn::kMonteCarlo}, {"sarsa", Learn::kSarsa}, {"expected-sarsa", Learn::kExpectedSarsa}});
  GridRules& rules = options_.rules;
  rules.sampling = given.Choice<Sampling>("sampling", {{"inversion-sphere", Sampling::kInversionSphere},
                                                       {"inversion-hemisphere", Sampling::kInversionHemisphere},
                                                       {"rejection", Sampling::kRejection},
                                                       {"rejection-mixed", Sampling::kRejectionMixed},
                                                       {"metropolis", Sampling::kMetropolis},
                                                       {"rejection-memo", Sampling::kRejection},
                                                       {"rejection-mixed-memo", Sampling::kRejectionMixed}});
  rules.memo = given.Text("sampling").ends_with("-memo");
  rules.mix =
      given.Text("mix") == "document" ? GridRules::kDocumentsMix : static_cast<float>(given.Number("mix", 0, 1));
  if (given.Text("bsdf-fraction") != "auto")
    options_.bsdf_fraction = static_cast<float>(given.Number("bsdf-fraction", 0.05, 0.95));
  options_.grid.cells = given.Integer("cells", 1, 32);
  options_.grid.directions = given.Choice<int>("directions", {{"4", 4}, {"8", 8}, {"16", 16}, {"32", 32}});
  options_.grid.learning_rate = static_cast<float>(given.Number("learning-rate", 1e-6, 1));
  options_.grid.prior = static_cast<float>(given.Number("prior", 0, 1000));
  options_.grid.Validate();
  options_.exploration = static_cast<uint32_t>(given.Integer("exploration", 1, 1000));
  options_.batch = static_cast<uint64_t>(given.Integer("batch", 1, 4096));
  const bool automatic = given.Text("steps") == "auto";
  options_.steps =
      automatic ? AutomaticSteps(job, options_.batch) : static_cast<uint32_t>(given.Integer("steps", 0, 100000));
  // After the last step there is to be guiding.
  if (options_.steps > 0 && options_.exploration > options_.steps) {
    if (!automatic) given.Refuse("exploration");
    options_.exploration = options_.steps;
  }
}

std::shared_ptr<const State> GridMethod::Initial() const {
  return std::make_shared<GridState>(RadianceGrid::Initial(bounds_, options_.grid));
}

std::shared_ptr<const State> GridMethod::ParseState(std::string_view bytes) const {
  auto grid = RadianceGrid::Parse(bytes);
  CheckOptions(grid->options(), options_.grid, "a grid guiding state");
  return std::make_shared<GridState>(std::move(grid));
}

std::unique_ptr<Statistics> GridMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  return std::make_unique<GridGuidingStatistics>(GridStatistics(As<GridState>(*state).grid()));
}

std::shared_ptr<const State> GridMethod::Advance(const std::shared_ptr<const State>& state,
                                                 const IterationResult& result) const {
  const auto& grid = As<GridState>(*state);
  // No unit recorded anything: the step is over all the same.
  if (result.statistics == nullptr)
    return std::make_shared<GridState>(lodestar::Advance(*grid.grid(), GridStatistics(grid.grid())));
  const auto& learned = As<GridGuidingStatistics>(*result.statistics);
  return std::make_shared<GridState>(lodestar::Advance(*grid.grid(), learned.sums()));
}

std::string GridMethod::Explain(const State& state) const {
  if (!options_.rules.memo) return {};
  std::string text = "a -memo sampling, for comparison only: BIASED";
  if (const auto integrals = MeasureIntegrals(GridSampling(As<GridState>(state).grid(), options_.rules))) {
    char line[160];
    std::snprintf(line, sizeof line,
                  ", as its densities integrate to %.4f, not 1 (mean over voxels and normals, which spread by %.4f)",
                  integrals->mean, integrals->spread);
    text += line;
  }
  return text;
}

}  // namespace lodestar
