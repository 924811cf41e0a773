// Which guide renders under a method's state, and what its paths are told: the one place of this half that knows every
// method.
#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/learning/focal_guiding.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/mixed_guiding.h"
#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/focal_guide.h"
#include "core/tracing/grid_guide.h"
#include "core/tracing/mixed_guide.h"
#include "core/tracing/path_kernel.h"
#include "core/tracing/sd_tree_guide.h"

namespace lodestar {

// visit(guide, settings), whose result is of one type for all guides: NoGuide for path tracing; where methods race,
// that of the one that renders under the state. Throws Error(kUnsupported) for a method without a guide here.
template <class Visit>
auto VisitGuide(const Scene& scene, const Method& job_method, const std::shared_ptr<const State>& job_state,
                Visit&& visit) {
  const Method::Active active = job_method.ActiveUnder(job_state);
  const auto state = [&]<class T>(std::type_identity<T>) {
    auto cast = std::dynamic_pointer_cast<const T>(active.state);
    LODESTAR_CHECK(cast);
    return cast;
  };
  PathSettings settings;
  settings.max_depth = scene.max_depth();
  // What an SD-tree decides on.
  const auto set = [&](const SdTreeMethod::Options& options, const SdTree& tree) {
    const size_t groups = tree.lights_by_power().size();
    LODESTAR_CHECK(groups == 0 || groups == scene.light_groups().size());
    settings.roulette = options.roulette;
    settings.next_event = SampledLights(scene, options.nee, tree.iteration());
  };
  if (const auto* path = dynamic_cast<const PathMethod*>(active.method)) {
    settings.next_event = SampledLights(scene, path->options().nee, 0);
    return visit(NoGuide{}, std::as_const(settings));
  }
  if (const auto* guided = dynamic_cast<const SdTreeMethod*>(active.method)) {
    const auto tree = state(std::type_identity<SdTreeState>());
    const SdTreeMethod::Options& options = guided->options();
    set(options, tree->tree());
    if (options.product) return visit(SdTreeGuide<true>(tree, options.learn), std::as_const(settings));
    return visit(SdTreeGuide<false>(tree, options.learn), std::as_const(settings));
  }
  if (const auto* mixed = dynamic_cast<const MixedMethod*>(active.method)) {
    const auto both = state(std::type_identity<MixedState>());
    const SdTreeMethod::Options& options = mixed->tree().options();
    set(options, both->tree()->tree());
    return visit(MixedGuide(both, options.learn), std::as_const(settings));
  }
  if (const auto* focal = dynamic_cast<const FocalMethod*>(active.method)) {
    settings.next_event = SampledLights(scene, focal->options().nee, 0);
    return visit(FocalGuide(state(std::type_identity<FocalState>())), std::as_const(settings));
  }
  if (const auto* grid = dynamic_cast<const GridMethod*>(active.method)) {
    settings.next_event = SampledLights(scene, grid->options().nee, 0);
    return visit(GridGuide(state(std::type_identity<GridState>())->grid(), grid->options()), std::as_const(settings));
  }
  throw Error(ErrorKind::kUnsupported,
              "method '" + std::string(active.method->name()) + "' has no tracing half in this build");
}

}  // namespace lodestar
