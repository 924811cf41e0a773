#include "core/tracing/tracer.h"

#include <algorithm>
#include <string>

#include "core/base/clock.h"
#include "core/learning/focal_guiding.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/mixed_guiding.h"
#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/focal_guide.h"
#include "core/tracing/grid_guide.h"
#include "core/tracing/mixed_guide.h"
#include "core/tracing/path_tracer.h"
#include "core/tracing/sd_tree_guide.h"

namespace lodestar {

extern template class PathTracer<NoGuide>;
extern template class PathTracer<FocalGuide>;
extern template class PathTracer<GridGuide>;
extern template class PathTracer<MixedGuide>;
extern template class PathTracer<SdTreeGuide<false>>;
extern template class PathTracer<SdTreeGuide<true>>;

CompiledJob CompileJob(const SceneDescription& description, const JobSpec& job) {
  SceneDescription adjusted = description;
  if (job.resolution_x > 0) adjusted.resolution_x = static_cast<int>(job.resolution_x);
  if (job.resolution_y > 0) adjusted.resolution_y = static_cast<int>(job.resolution_y);
  if (job.max_depth > 0) adjusted.max_depth = job.max_depth;
  if (!job.filter.empty()) adjusted.filter = PixelFilterDescription::Named(job.filter);
  CompiledJob compiled;
  const Clock::Duration start = Clock::Steady().Now();
  compiled.scene = Scene::Compile(adjusted);
  compiled.seconds = Seconds(Clock::Steady().Now() - start);
  compiled.survey.bounds = compiled.scene->bounds();
  compiled.survey.resolution_x = static_cast<uint32_t>(compiled.scene->resolution_x());
  compiled.survey.resolution_y = static_cast<uint32_t>(compiled.scene->resolution_y());
  compiled.survey.max_depth = compiled.scene->max_depth();
  compiled.survey.scene_spp = static_cast<uint64_t>(std::max(1, description.samples_per_pixel));
  compiled.survey.scene_hash = compiled.scene->hash().hex;
  compiled.survey.needs = compiled.scene->needs().ToString();
  compiled.survey.not_needed = compiled.scene->needs().NotNeeded();
  compiled.survey.guidable = compiled.scene->needs().Guidable();
  compiled.survey.light_groups = compiled.scene->light_groups();
  compiled.survey.SetLeftOut(description.left_out);
  return compiled;
}

std::unique_ptr<Tracer> PrepareTracer(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& job_method,
                                      std::shared_ptr<const State> job_state) {
  Method::Active active = job_method.ActiveUnder(job_state);
  const Method& method = *active.method;
  std::shared_ptr<const State>& state = active.state;
  PathSettings settings;
  settings.max_depth = scene->max_depth();
  if (const auto* path = dynamic_cast<const PathMethod*>(&method)) {
    settings.next_event = SampledLights(*scene, path->options().nee, 0);
    return std::make_unique<PathTracer<NoGuide>>(std::move(scene), job.seed, settings, NoGuide{});
  }
  // What an SD-tree decides on.
  const auto set = [&](const SdTreeMethod::Options& options, const SdTree& tree) {
    const size_t groups = tree.lights_by_power().size();
    LODESTAR_CHECK(groups == 0 || groups == scene->light_groups().size());
    settings.roulette = options.roulette;
    settings.next_event = SampledLights(*scene, options.nee, tree.iteration());
  };
  if (const auto* guided = dynamic_cast<const SdTreeMethod*>(&method)) {
    auto tree_state = std::dynamic_pointer_cast<const SdTreeState>(std::move(state));
    LODESTAR_CHECK(tree_state);
    set(guided->options(), tree_state->tree());
    const auto make = [&]<bool kProduct>(std::bool_constant<kProduct>) -> std::unique_ptr<Tracer> {
      using Guide = SdTreeGuide<kProduct>;
      return std::make_unique<PathTracer<Guide>>(std::move(scene), job.seed, settings,
                                                 Guide(std::move(tree_state), guided->options().learn));
    };
    return guided->options().product ? make(std::true_type()) : make(std::false_type());
  }
  if (const auto* mixed = dynamic_cast<const MixedMethod*>(&method)) {
    const auto mixed_state = std::dynamic_pointer_cast<const MixedState>(std::move(state));
    LODESTAR_CHECK(mixed_state);
    set(mixed->tree().options(), mixed_state->tree()->tree());
    return std::make_unique<PathTracer<MixedGuide>>(std::move(scene), job.seed, settings,
                                                    MixedGuide(mixed_state, mixed->tree().options().learn));
  }
  if (const auto* focal = dynamic_cast<const FocalMethod*>(&method)) {
    auto focal_state = std::dynamic_pointer_cast<const FocalState>(std::move(state));
    LODESTAR_CHECK(focal_state);
    settings.next_event = SampledLights(*scene, focal->options().nee, 0);
    return std::make_unique<PathTracer<FocalGuide>>(std::move(scene), job.seed, settings,
                                                    FocalGuide(std::move(focal_state)));
  }
  if (const auto* grid = dynamic_cast<const GridMethod*>(&method)) {
    auto grid_state = std::dynamic_pointer_cast<const GridState>(std::move(state));
    LODESTAR_CHECK(grid_state);
    settings.next_event = SampledLights(*scene, grid->options().nee, 0);
    return std::make_unique<PathTracer<GridGuide>>(std::move(scene), job.seed, settings,
                                                   GridGuide(grid_state->grid(), grid->options()));
  }
  throw Error(ErrorKind::kUnsupported, "method '" + std::string(method.name()) + "' has no tracing half in this build");
}

}  // namespace lodestar
