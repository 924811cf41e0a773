// The coordinator without its wire: jobs, workers, leases and merging, in plain values. One mutex; what takes long
// (decoding, merging, disk) happens outside of it. Long polls are parked here as functions that are called once, from
// any thread and without the mutex.
//
// Methods throw Error for what a caller did wrong; a worker that is not known gets Error(kNotFound).
#pragma once

#include <condition_variable>
#include <functional>
#include <list>

#include "coordinator/blob_store.h"
#include "coordinator/checkpoint.h"
#include "coordinator/job.h"
#include "core/base/memory.h"

namespace lodestar {

class Farm {
 public:
  struct Options {
    std::filesystem::path store;
    LeaseTable::Options leases;
    Clock::Duration checkpoint_interval = std::chrono::seconds(30);
    Clock::Duration checkpoint_least =
        std::chrono::seconds(2);  // between those at iteration ends, which come fast at first
    uint32_t max_running = 4;
    size_t max_queued = 1000;
    int strikes = 3;  // workers a job may cost
    // The films of one job may take half of it.
    uint64_t memory_bytes = UsableMemory();
    BlobStore::Options blobs;
    // An advance is the coordinator's alone for this share of the iteration that it ends; what is left of it then is
    // offered to workers in shards.
    double alone_share = 0.03;
    const Clock* clock = &Clock::Steady();
    std::function<void(const std::string&)>
        fatal;  // this coordinator must end (another has taken over); from any thread
  };
  explicit Farm(Options options);
  ~Farm();

  // ---- clients (farm_clients.cpp) ----
  JobId Submit(const JobSubmission& submission);
  JobStatus Get(const JobId& id) const;
  std::vector<JobStatus> List() const;
  void Cancel(const JobId& id);
  std::shared_ptr<const Image> GetImage(const JobId& id);  // waits for a round's edge, at most a few seconds
  std::string GetReport(const JobId& id);
  Bytes GetGuide(const JobId& id);  // GuideFile: what it has learned so far, or had when it ended
  std::vector<WorkerStatus> Workers() const;
  BlobStore& blobs() { return *blobs_; }
  // `changed` is called with every change from now on, and at once with the present.
  uint64_t Watch(const JobId& id, std::function<void(const JobStatus&)> changed);
  void Unwatch(uint64_t watch);  // a call that is under way still comes

  // ---- workers (farm_workers.cpp, farm_results.cpp) ----
  Registration Register(const WorkerInfo& info);
  using LeaseAnswer = std::function<void(std::optional<LeasedUnit>)>;
  using RenewAnswer = std::function<void(std::vector<LeaseId>)>;
  // The answer comes now or later; the number serves to withdraw a parked call (0: answered).
  uint64_t Lease(const WorkerId& worker, Clock::Duration wait, LeaseAnswer answer);
  uint64_t RenewLease(const WorkerId& worker, const std::vector<LeaseId>& leases, Clock::Duration wait,
                      RenewAnswer answer);
  void Withdraw(uint64_t call);
  std::shared_ptr<const Bytes> StateBytes(const ContentHash& hash) const;
  ContributionOutcome SubmitContribution(const ContributionHeader& header, std::string_view bytes);
  void SubmitSurvey(const SurveyResult& result);
  // Throws Error(kCorrupt) where it is no answer.
  void SubmitShard(const ShardAnswer& answer);
  void ReportFailure(const UnitFailure& failure);

  uint64_t epoch() const { return store_.epoch(); }

 private:
  class FarmExecutor;
  struct Worker {
    WorkerInfo info;
    std::string fingerprint;  // info.Fingerprint(), which is made anew each time
    Clock::Duration seen{};
    std::vector<LeaseId> revoked;  // to be told
    uint64_t units = 0;
    double seconds = 0;  // of rendering
  };
  template <class Answer>
  struct Parked {
    uint64_t call;
    WorkerId worker;
    Clock::Duration until;  // then it is answered with nothing
    Answer answer;
  };
  // Of all workers that may render a job together, in passes over a unit a second; what is asked for, summed once.
  using Speeds = std::map<const Job*, double>;
  struct Watcher {
    int64_t job;
    std::function<void(const JobStatus&)> changed;
  };
  // Calls to make once the mutex is released: declare before the lock.
  class Deferred {
   public:
    ~Deferred() {
      for (auto& call : calls_) call();
    }
    void Add(std::function<void()> call) { calls_.push_back(std::move(call)); }

   private:
    std::vector<std::function<void()>> calls_;
  };

  // All below with mutex_ held, unless they say otherwise.
  Job& Need(const JobId& id) const;
  Worker& NeedWorker(const WorkerId& id);
  JobStatus Status(const Job& job) const;
  void Changed(const Job& job, Deferred* deferred);
  LeaseId NewLeaseId() { return {(store_.epoch() << 32) | ++last_lease_}; }
  uint32_t LiveWorkers(const std::string& fingerprint) const;
  bool LeftToOthers(const Job& job, const WorkerId& worker) const;
  std::optional<LeasedUnit> GrantSurvey(const WorkerId& id);
  std::shared_ptr<ShardTable> ShardsOf(const JobId& id) const;  // null: none are offered
  std::optional<LeasedUnit> GrantShard(const WorkerId& id, const Worker& worker);
  std::optional<LeasedUnit> GrantRender(const WorkerId& id, const Worker& worker, bool copies, Speeds* speeds);
  // `speeds`: of the calls that are answered while mutex_ is held.
  std::optional<LeasedUnit> GrantFor(const WorkerId& id, Speeds* speeds);
  LeasedUnit UnitOf(const Job& job, LeaseId lease) const;  // what it is remains to be said
  void Pump(Deferred* deferred);                           // answers parked calls that can be answered
  void Revoke(const std::vector<LeaseEntry>& leases);
  void CloseRounds(Job& job, const std::function<bool(const OpenRound&)>& which);
  void CountLoss(Job& job, const WorkerId& worker);
  void FailRunning(Job& job, const std::string& why);
  void Reorder();
  void StartDrivers();
  void Tick(Deferred* deferred);
  // Without mutex_ (takes job.persist, then mutex_): changes `stored` and writes it.
  void Persist(Job& job, const std::function<void(StoredJob&)>& change);
  // The same for a job that has ended with it: its checkpoint goes.
  void PersistEnd(Job& job, const std::function<void(StoredJob&)>& change);
  void EndJob(Job& job, JobPhase phase, const std::string& error);
  // Throws what Loop's constructor would, and ExhaustedError for a picture that is too large for this coordinator's
  // memory.
  void CheckJob(const JobSpec& spec, const Survey& survey) const;
  // Without mutex_: what takes long is filled in.
  void AnswerLease(const LeaseAnswer& answer, std::optional<LeasedUnit> unit);
  // On other threads, without mutex_.
  void Load();
  void Drive(Job& job);
  void End(Job& job, const Loop* loop, std::string failure);
  void StoreResult(Job& job, const Loop& loop, JobPhase phase, const std::string& error);
  void StoreCheckpoint(Job& job, JobCheckpoint checkpoint);
  void Snapshot(Job& job, const Loop& loop);
  // With mutex_ held by `lock`: until the driver has shown where a running job is, at most a few seconds. At once where
  // there is nothing to show.
  void AwaitSnapshot(Job& job, std::unique_lock<std::mutex>& lock);
  void TimerLoop();

  Options options_;
  const Clock& clock_;
  JobStore store_;
  std::unique_ptr<BlobStore> blobs_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;  // rounds completed, jobs stopped, snapshots made
  std::condition_variable timer_wake_;
  std::map<int64_t, std::unique_ptr<Job>> jobs_;
  std::vector<Job*> order_;  // those that have not ended, by priority and age
  std::map<WorkerId, Worker> workers_;
  std::list<Parked<LeaseAnswer>> parked_leases_;
  std::list<Parked<RenewAnswer>> parked_renewals_;
  std::map<uint64_t, Watcher> watchers_;
  uint64_t last_lease_ = 0, last_call_ = 0, last_worker_ = 0;
  bool ending_ = false;
  Clock::Duration next_collection_{};
  std::thread timer_;
  const std::string tree_canary_;  // workers must round as this process does to share in its work
};

}  // namespace lodestar
