// A worker: leases units, renders them, delivers what came out. Four threads: one asks for the next lease and fetches
// its state while the current one renders; one renders (on as many threads as worker and job allow) and gathers what
// leases of one round bring; one delivers; one keeps the leases alive and hears which to give up.
//
// It may be killed at any time; whatever it held is rendered by others. While its coordinator is away it tries again,
// for ever.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <map>

#include "rpc/retry.h"
#include "worker/job_cache.h"

namespace lodestar {

class Worker {
 public:
  struct Options {
    std::string coordinator;  // HOST:PORT
    int threads = 0;          // 0: UsableThreads()
    std::filesystem::path cache;
    uint64_t cache_bytes = uint64_t{20} << 30;
    CompileTrial::Options trial;  // its memory is that of all compiled scenes, too
    std::string name;             // "": host:pid
  };
  explicit Worker(const Options& options);
  ~Worker();

  // Runs until drained; throws ProtocolError where the coordinator is of another release.
  void Run();
  // Of trees that it was to make for advances; once Run() has returned.
  uint64_t shards() const { return shards_; }
  // Finishes and delivers the unit at hand, gives back the others, and lets Run return. From any thread.
  void Drain();

 private:
  struct Held {
    LeasedUnit unit;
    std::shared_ptr<StopToken> stop = std::make_shared<StopToken>();
  };
  // What leases of one round have brought together, on its way out.
  struct Gathered {
    std::vector<Held> leases;
    ContributionHeader header;
    Contribution contribution;
    std::shared_ptr<LoadedJob> job;
    std::shared_ptr<const State> state;
  };
  void FetchLoop();
  void RenderLoop();
  void DeliverLoop();
  void KeepLoop();
  void Survey(const Held& held);
  void MakeTrees(const Held& held);
  void Render(const Held& held);
  void Deliver();  // what is gathered
  void Send(Gathered& delivery, const std::string& what);
  // To be rendered by others; where there is a fault, the first lease carries it.
  void GiveBack(const std::vector<Held>& leases, UnitFailure::Kind kind = UnitFailure::Kind::kReturned,
                std::string why = "");
  void Fail(const Held& held, UnitFailure::Kind kind, const std::string& message);
  // Repeats until it was answered, the unit is void, or this worker gives up at its end.
  void Persistently(const StopToken* stop, const std::function<void()>& call);
  void Release(LeaseId lease);
  WorkerId Id();                    // registers where needed
  void Forget(const WorkerId& id);  // that incarnation is unknown to the coordinator
  void Fatal(std::exception_ptr error);

  const Options options_;
  const WorkerInfo info_;
  WorkClient leasing_, working_,
      keeping_;  // of their own connections: cancelled at different times, and none waits behind another
  AssetCache assets_;
  JobCache jobs_;

  std::optional<Gathered> gathered_;  // of the rendering thread
  // Of the rendering thread, and of the delivering one: what the log says at the end.
  uint64_t leases_ = 0, shards_ = 0, deliveries_made_ = 0, delivered_bytes_ = 0;
  double rendering_seconds_ = 0, delivering_seconds_ = 0;

  std::mutex register_;
  std::mutex mutex_;
  std::condition_variable changed_;
  WorkerId id_;
  Clock::Duration lease_duration_ = std::chrono::seconds(10);
  std::deque<Held> ready_;
  std::deque<Gathered> deliveries_;
  std::map<LeaseId, std::shared_ptr<StopToken>> held_;
  bool draining_ = false, fetched_ = false, rendered_ = false, delivered_ = false;
  StopToken drain_, abandon_;
  std::exception_ptr fatal_;
};

}  // namespace lodestar
