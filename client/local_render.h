// A render in this process.
#pragma once

#include <functional>
#include <memory>

#include "client/progress.h"
#include "core/base/stop.h"
#include "core/learning/guide_file.h"
#include "core/learning/loop.h"
#include "core/tracing/tracer.h"

namespace lodestar {

struct RenderResult {
  Image image;
  JobReport report;
  std::shared_ptr<const State> state;  // at the end
};

// Throws Error(kInvalidInput) for a job in which nothing is learned that --state could save.
void CheckLearns(const CompiledJob& compiled, const JobSpec& job);
// Runs the job to its budget or to a stop request. `guide`, where given, is filled with what was learned.
// `after_round`, where given, is called at each round's edge, outside of the run time. Throws Error.
RenderResult RenderLocally(const CompiledJob& compiled, const JobSpec& job, int threads,
                           const std::shared_ptr<const Image>& reference, const StopToken& stop, ProgressLine& progress,
                           GuideFile* guide = nullptr,
                           const std::function<void(const Loop&, const JobProgress&)>& after_round = {});

// CompileJob, with its errors turned into CommandError(kBadScene).
CompiledJob CompileScene(const SceneDescription& description, const JobSpec& job);

}  // namespace lodestar
