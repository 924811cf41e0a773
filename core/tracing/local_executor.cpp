#include "core/tracing/local_executor.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#ifdef __SANITIZE_THREAD__
#include <exception>
#include <thread>
#endif

#include "core/base/check.h"
#include "core/base/threads.h"

namespace lodestar {
namespace {

// Runs body(0) to body(shares - 1) at the same time where the arena has the threads, and waits for them.
template <typename Body>
void RunShares(tbb::task_arena* arena, int shares, const Body& body) {
#ifdef __SANITIZE_THREAD__
  // ThreadSanitizer does not see how TBB, which is not instrumented, hands work over, and reports all of it. To suppress
  // what has a frame of TBB's would hide the races of every tracer too, so that build has plain threads here.
  std::vector<std::exception_ptr> failures(static_cast<size_t>(shares));
  {
    std::vector<std::jthread> threads;
    for (int share = 0; share < shares; ++share) {
      threads.emplace_back([&body, &failure = failures[static_cast<size_t>(share)], share] {
        try {
          body(share);
        } catch (...) {
          failure = std::current_exception();
        }
      });
    }
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
#else
  arena->execute([&] { tbb::parallel_for(0, shares, body, tbb::simple_partitioner()); });
#endif
}

}  // namespace

struct LocalExecutor::Impl {
  std::shared_ptr<const Scene> scene;
  JobSpec job;
  const Method& method;
  int threads;
  tbb::task_arena arena;
  // The tracer of the last state: prepared once an iteration.
  std::shared_ptr<const State> prepared_state;
  std::unique_ptr<Tracer> tracer;

  Impl(std::shared_ptr<const Scene> s, const JobSpec& j, const Method& m, int t) : scene(std::move(s)), job(j), method(m), threads(t), arena(t) {}
};

LocalExecutor::LocalExecutor(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method, int threads)
    : impl_(std::make_unique<Impl>(std::move(scene), job, method, threads > 0 ? threads : UsableThreads())) {}

LocalExecutor::~LocalExecutor() = default;

std::optional<Contribution> LocalExecutor::Execute(const std::shared_ptr<const State>& state, const Round& round, const StopToken& stop) {
  return ExecuteNode(state, round, TreeNode::Root(round.unit_count), stop);
}

std::optional<Contribution> LocalExecutor::ExecuteNode(const std::shared_ptr<const State>& state, const Round& round, TreeNode node, const StopToken& stop) {
  if (!impl_->tracer || impl_->prepared_state != state) {
    impl_->tracer = PrepareTracer(impl_->scene, impl_->job, impl_->method, state);
    impl_->prepared_state = state;
  }
  // Threads take units one by one, so that none waits for a slow block; exact merging makes the shares' shapes irrelevant to the result.
  const uint32_t end = node.end(round.unit_count);
  std::atomic<uint32_t> next{node.first()};
  std::atomic<bool> complete{true};
  const int shares = std::max(1, std::min<int>(impl_->threads, static_cast<int>(end - node.first())));
  std::vector<Contribution> parts(static_cast<size_t>(shares));
  RunShares(&impl_->arena, shares, [&](int share) {
    Contribution& part = parts[static_cast<size_t>(share)];
    if (round.record) part.statistics = impl_->method.NewStatistics(state);
    for (uint32_t unit; (unit = next.fetch_add(1)) < end;) {
      if (!impl_->tracer->Execute(round, unit, stop, &part)) {
        complete = false;
        return;
      }
    }
  });
  if (!complete) return std::nullopt;
  Contribution whole = std::move(parts[0]);
  for (int share = 1; share < shares; ++share) whole.Merge(std::move(parts[static_cast<size_t>(share)]));
  LODESTAR_CHECK(whole.tiles.size() == end - node.first());
  return whole;
}

}  // namespace lodestar
