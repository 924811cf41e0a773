// Jobs that this worker can render: scenes compiled, methods made, states parsed; least recently used out first.
#pragma once

#include <list>
#include <memory>
#include <mutex>

#include "core/tracing/local_executor.h"
#include "rpc/work_client.h"
#include "worker/asset_cache.h"
#include "worker/compile_trial.h"

namespace lodestar {

// A job with its scene compiled.
class LoadedJob {
 public:
  // `threads`: those that this worker may use; a job may ask for fewer.
  LoadedJob(const JobDescription& description, std::filesystem::path folder, CompiledJob compiled, int threads);
  ~LoadedJob();
  const Survey& survey() const { return compiled_.survey; }
  int threads() const { return threads_; }  // that it is rendered on
  // The last two states are kept: a lease of the next iteration is prepared while one of the last still runs.
  std::shared_ptr<const State> StateFor(const ContentHash& hash, WorkClient& client);
  // LocalExecutor::ExecuteNode
  bool Execute(const RenderUnit& unit, const std::shared_ptr<const State>& state, const StopToken& stop,
               Contribution* into);

 private:
  const std::filesystem::path folder_;  // textures may be read late
  const CompiledJob compiled_;
  const std::unique_ptr<Method> method_;
  const int threads_;
  LocalExecutor executor_;
  std::mutex states_mutex_;
  std::list<std::pair<ContentHash, std::shared_ptr<const State>>> states_;
  uint64_t fetched_ = 0;  // with the time that it took, for the log
  double fetching_seconds_ = 0;
};

class JobCache {
 public:
  // Scenes that together took no more memory to compile than `trial` allows one of them are kept. Jobs are rendered on
  // `threads` at most.
  JobCache(AssetCache& assets, WorkClient& client, const CompileTrial::Options& trial, int threads)
      : assets_(assets), client_(client), trial_(trial), threads_(threads) {}
  // Compiles where it must: in this process, once a child has done so within the limits. Throws Error: messages about
  // the scene name its files as the client knows them; kIo where it was not the scene's fault, or `stop` was requested;
  // UnreachableError while the coordinator is away.
  std::shared_ptr<LoadedJob> Load(const ContentHash& description, const StopToken& stop);
  // Nothing where it is not loaded.
  std::shared_ptr<LoadedJob> Find(const ContentHash& description);

 private:
  AssetCache& assets_;
  WorkClient& client_;
  const CompileTrial trial_;
  const int threads_;
  struct Entry {
    ContentHash description;
    std::shared_ptr<LoadedJob> job;
    uint64_t bytes;
  };
  void MakeRoom(uint64_t bytes);
  std::mutex mutex_;
  std::list<Entry> jobs_;  // the last used first
};

}  // namespace lodestar
