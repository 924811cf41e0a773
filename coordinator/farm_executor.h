// Rounds by leases: opens a round (and the announced one behind it), and waits until workers have covered it.
#pragma once

#include <functional>

#include "coordinator/farm.h"

namespace lodestar {

class Farm::FarmExecutor final : public Executor, private ShardRunner {
 public:
  // `checkpoint` is called on the driver's thread every now and then while a round is under way, and once more where
  // the farm ends within one.
  FarmExecutor(Farm& farm, Job& job, const Loop& loop, JobCheckpoint resumed,
               std::function<void(const OpenRound*)> checkpoint);
  ~FarmExecutor() override;
  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override;
  ShardRunner* shards() override { return this; }
  // What the loop is to run by.
  const Clock& clock() const { return run_->busy; }
  void Announce(const std::shared_ptr<const State>& state, const Round& next) override { announced_ = next; }

 private:
  // Here at first; together with workers once it has taken longer than a share of the iteration that it ends.
  void Run(ShardedWork& work) override;
  void Publish(const std::shared_ptr<const State>& state);
  std::shared_ptr<OpenRound> NewRound(const Round& round) const;
  void Resume(OpenRound* open);

  Farm& farm_;
  Job& job_;
  const std::shared_ptr<JobRun> run_;
  JobCheckpoint resumed_;
  std::function<void(const OpenRound*)> checkpoint_;
  std::optional<Round> announced_;
  // By clock(): when the state was published, and when the last round under it ended.
  Clock::Duration published_{};
  std::optional<Clock::Duration> ended_;
};

}  // namespace lodestar
