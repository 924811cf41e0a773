#include "client/local_render.h"

#include <tbb/global_control.h>

#include "client/exit_code.h"
#include "core/base/threads.h"
#include "core/tracing/local_executor.h"

namespace lodestar {

CompiledJob CompileScene(const SceneDescription& description, const JobSpec& job) {
  try {
    return CompileJob(description, job);
  } catch (const Error& error) {
    throw CommandError(ExitCode::kBadScene, error.what());
  }
}

void CheckLearns(const CompiledJob& compiled, const JobSpec& job) {
  if (Learns(*MakeMethod(job, compiled.survey))) return;
  throw Error(ErrorKind::kInvalidInput,
              "--state: method '" + job.method + "' learns nothing that could be saved; try --method sdtree");
}

RenderResult RenderLocally(const CompiledJob& compiled, const JobSpec& job, int threads,
                           const std::shared_ptr<const Image>& reference, const StopToken& stop, ProgressLine& progress,
                           GuideFile* guide, const std::function<void(const Loop&, const JobProgress&)>& after_round) {
  // Learning's loops too, which are not the executor's.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads > 0 ? threads : UsableThreads()));
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), threads);
  Loop::Hooks hooks;
  hooks.reference = reference;
  hooks.progress = [&](const JobProgress& at) {
    progress.Update(at);
    if (after_round) after_round(loop, at);
  };
  if (guide != nullptr) {
    hooks.advanced = [&](const std::shared_ptr<const State>& from, const Statistics* learned,
                         const std::shared_ptr<const State>& to) {
      const Method::Active trained = loop.method().ActiveUnder(from);
      if (learned != nullptr) guide->training = {trained.state->Serialize(), learned->Serialize()};
      if (loop.method().ActiveUnder(to).method != trained.method) guide->training.reset();
    };
  }
  loop.Run(executor, stop, hooks);
  progress.Finish();
  RenderResult result;
  if (loop.passes() > 0) result.image = loop.Develop();
  result.report = FinalReport(loop, result.image);
  result.state = loop.state();
  if (guide != nullptr) {
    guide->job = job;
    guide->survey = compiled.survey;
    guide->iterations = result.report.iterations - 1;
    guide->state = result.state->Serialize();
  }
  return result;
}

}  // namespace lodestar
