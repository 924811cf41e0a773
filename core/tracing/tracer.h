// The tracing half of a method: it renders units where the scene is compiled. `Prepare` holds what all units of an
// iteration share.
#pragma once

#include <memory>
#include <optional>

#include "core/base/stop.h"
#include "core/learning/job.h"
#include "core/learning/method.h"
#include "core/scene/scene.h"

namespace lodestar {

// Rendering of one iteration on one scene: immutable, shared by threads.
class Tracer {
 public:
  virtual ~Tracer() = default;
  // Renders one unit of the round and adds it to `into` (which holds other units of the same round): a pure function of
  // state, round and unit. False where `stop` was requested first (seen within 100 ms); `into` is then to be thrown
  // away.
  virtual bool Execute(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const = 0;
  // One pixel sample as Execute renders it in that round, for replaying what the health report names.
  virtual Rgb TraceSample(const Round& round, uint32_t x, uint32_t y, uint32_t pass) const = 0;
};

// Throws Error(kInvalidInput) where the method has no tracing half for this state.
std::unique_ptr<Tracer> PrepareTracer(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method,
                                      std::shared_ptr<const State> state);

// Compiles the scene of a job (resolution, filter and depth overrides applied) and says what the learning half needs to
// know of it.
struct CompiledJob {
  std::shared_ptr<const Scene> scene;
  Survey survey;
  double seconds = 0;  // that compiling took, meshes and images read, without parsing
};
CompiledJob CompileJob(const SceneDescription& description, const JobSpec& job);

}  // namespace lodestar
