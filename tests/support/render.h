// Renders in this process, for tests that look at whole pictures.
#pragma once

#include <memory>
#include <string>

#include "core/learning/loop.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "core/tracing/tracer.h"

namespace lodestar::test {

struct Rendered {
  Image image;
  JobReport report;
  std::string state;  // canonical bytes of the last state
};

inline Rendered Render(const CompiledJob& compiled, const JobSpec& job, int threads = 0) {
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), threads);
  const StopToken stop;
  loop.Run(executor, stop, {});
  return {loop.Develop(), loop.Report(), loop.state() ? loop.state()->Serialize() : std::string()};
}

inline Rendered RenderText(const std::string& pbrt, const JobSpec& job, int threads = 0) {
  return Render(CompileJob(ParsePbrtText(pbrt, "test.pbrt", "."), job), job, threads);
}

}  // namespace lodestar::test
