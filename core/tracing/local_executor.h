// Rounds on the threads of this process (oneTBB); also what a worker runs a lease with.
#pragma once

#include "core/learning/loop.h"
#include "core/tracing/tracer.h"

namespace lodestar {

class LocalExecutor final : public Executor {
 public:
  // threads 0: UsableThreads().
  LocalExecutor(std::shared_ptr<const Scene> scene, const JobSpec& job, const Method& method, int threads = 0);
  ~LocalExecutor() override;
  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override;
  // One node of the round's tree, a worker's lease, added to `into`: empty, or of other nodes of the same round. False
  // where `stop` came first: then `into` is of no use, since what half a unit has recorded cannot be taken out again.
  bool ExecuteNode(const std::shared_ptr<const State>& state, const Round& round, TreeNode node, const StopToken& stop,
                   Contribution* into);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lodestar
