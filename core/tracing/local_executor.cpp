#include "core/tracing/local_executor.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/threads.h"

namespace lodestar {

struct LocalExecutor::Impl {
  std::shared_ptr<const Scene> scene;
  JobSpec job;
  const Method& method;
  int threads;
  tbb::task_arena arena;
  // The tracer of the last state: prepared once an iteration.
  std::shared_ptr<const State> prepared_state;
  std::unique_ptr<Tracer> tracer;

  Impl(std::shared_ptr<const Scene> s, const JobSpec& j, const Method& m, int t)
      : scene(std::move(s)), job(j), method(m), threads(t), arena(t) {}
};

LocalExecutor::LocalExecutor(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method, int threads)
    : impl_(std::make_unique<Impl>(std::move(scene), job, method, threads > 0 ? threads : UsableThreads())) {}

LocalExecutor::~LocalExecutor() = default;

std::optional<Contribution> LocalExecutor::Execute(const std::shared_ptr<const State>& state, const Round& round,
                                                   const StopToken& stop) {
  Contribution whole;
  if (!ExecuteNode(state, round, TreeNode::Root(round.unit_count), stop, &whole)) return std::nullopt;
  return whole;
}

bool LocalExecutor::ExecuteNode(const std::shared_ptr<const State>& state, const Round& round, TreeNode node,
                                const StopToken& stop, Contribution* into) {
  if (!impl_->tracer || impl_->prepared_state != state) {
    impl_->tracer = PrepareTracer(impl_->scene, impl_->job, impl_->method, state);
    impl_->prepared_state = state;
  }
  // Threads take units one by one, so that none waits for a slow block; exact merging makes the shares' shapes
  // irrelevant to the result.
  const uint32_t end = node.end(round.unit_count);
  std::atomic<uint32_t> next{node.first()};
  std::atomic<bool> complete{true};
  const int shares = std::max(1, std::min<int>(impl_->threads, static_cast<int>(end - node.first())));
  std::vector<Contribution> parts(static_cast<size_t>(shares));
  parts[0].statistics = std::move(into->statistics);
  const auto render = [&](uint32_t share) {
    Contribution& part = parts[share];
    if (round.record && !part.statistics) part.statistics = impl_->method.NewStatistics(state);
    for (uint32_t unit; (unit = next.fetch_add(1)) < end;) {
      if (!impl_->tracer->Execute(round, unit, stop, &part)) {
        complete = false;
        return;
      }
    }
  };
  impl_->arena.execute([&] { ParallelFor<tbb::simple_partitioner>(static_cast<uint32_t>(shares), render); });
  if (!complete) return false;
  const size_t before = into->tiles.size();
  for (Contribution& part : parts) into->Merge(std::move(part));
  LODESTAR_CHECK(into->tiles.size() == before + (end - node.first()));
  return true;
}

}  // namespace lodestar
