#include "core/tracing/tracer.h"

#include <algorithm>
#include <utility>

#include "core/base/clock.h"
#include "core/tracing/path_tracer.h"
#include "core/tracing/visit_guide.h"

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

std::unique_ptr<Tracer> PrepareTracer(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method,
                                      std::shared_ptr<const State> state) {
  return VisitGuide(*scene, method, state,
                    [&]<class Guide>(Guide guide, const PathSettings& settings) -> std::unique_ptr<Tracer> {
                      return std::make_unique<PathTracer<Guide>>(scene, job.seed, settings, std::move(guide));
                    });
}

}  // namespace lodestar
