#include "core/tracing/tracer.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/path_tracer.h"

namespace lodestar {
namespace {

// Whole CPUs of the cgroup's quota, or nothing where there is none (cgroup v2, then v1).
std::optional<int> CgroupCpus() {
  const auto cpus = [](double quota, double period) { return std::max(1, static_cast<int>(quota / period + 0.5)); };
  if (std::ifstream v2("/sys/fs/cgroup/cpu.max"); v2) {
    std::string quota;
    double period = 0;
    if (v2 >> quota >> period && quota != "max" && period > 0) return cpus(std::stod(quota), period);
    return std::nullopt;
  }
  std::ifstream quota_file("/sys/fs/cgroup/cpu/cpu.cfs_quota_us"), period_file("/sys/fs/cgroup/cpu/cpu.cfs_period_us");
  double quota = 0, period = 0;
  if (quota_file >> quota && period_file >> period && quota > 0 && period > 0) return cpus(quota, period);
  return std::nullopt;
}

}  // namespace

int UsableThreads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  int threads = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
  if (const auto quota = CgroupCpus()) threads = std::min(threads, *quota);
  return std::max(threads, 1);
}

CompiledJob CompileJob(const SceneDescription& description, const JobSpec& job) {
  SceneDescription adjusted = description;
  if (job.resolution_x > 0) adjusted.resolution_x = static_cast<int>(job.resolution_x);
  if (job.resolution_y > 0) adjusted.resolution_y = static_cast<int>(job.resolution_y);
  if (job.max_depth > 0) adjusted.max_depth = job.max_depth;
  if (!job.filter.empty()) adjusted.filter = PixelFilterDescription::Named(job.filter);
  CompiledJob compiled;
  compiled.scene = Scene::Compile(adjusted);
  compiled.survey.bounds = compiled.scene->bounds();
  compiled.survey.resolution_x = static_cast<uint32_t>(compiled.scene->resolution_x());
  compiled.survey.resolution_y = static_cast<uint32_t>(compiled.scene->resolution_y());
  compiled.survey.max_depth = compiled.scene->max_depth();
  compiled.survey.scene_spp = static_cast<uint64_t>(std::max(1, description.samples_per_pixel));
  compiled.survey.scene_hash = compiled.scene->hash().hex;
  compiled.survey.needs = compiled.scene->needs().ToString();
  compiled.survey.SetLeftOut(description.left_out);
  return compiled;
}

std::unique_ptr<Tracer> PrepareTracer(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method, std::shared_ptr<const State> state) {
  PathSettings settings;
  settings.max_depth = scene->max_depth();
  if (const auto* path = dynamic_cast<const PathMethod*>(&method)) {
    settings.next_event = path->options().nee == NeeMode::kAlways && scene->has_lights();
    return std::make_unique<PathTracer>(std::move(scene), job.seed, settings, nullptr);
  }
  if (const auto* guided = dynamic_cast<const SdTreeMethod*>(&method)) {
    auto tree_state = std::dynamic_pointer_cast<const SdTreeState>(std::move(state));
    LODESTAR_CHECK(tree_state);
    settings.next_event = UsesNee(guided->options().nee, tree_state->tree().iteration()) && scene->has_lights();
    return std::make_unique<PathTracer>(std::move(scene), job.seed, settings, std::move(tree_state));
  }
  throw Error(ErrorKind::kUnsupported, "method '" + std::string(method.name()) + "' has no tracing half in this build");
}

}  // namespace lodestar
