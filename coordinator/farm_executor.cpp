#include "coordinator/farm_executor.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "core/base/check.h"
#include "core/base/log.h"

namespace lodestar {

Farm::FarmExecutor::FarmExecutor(Farm& farm, Job& job, const Loop& loop, JobCheckpoint resumed,
                                 std::function<void(const OpenRound*)> checkpoint)
    : farm_(farm),
      job_(job),
      run_(std::make_shared<JobRun>(loop, farm.clock_)),
      resumed_(std::move(resumed)),
      checkpoint_(std::move(checkpoint)) {
  run_->busy.Begin();
  std::lock_guard lock(farm_.mutex_);
  job_.run = run_;
}

Farm::FarmExecutor::~FarmExecutor() {
  Deferred deferred;
  std::lock_guard lock(farm_.mutex_);
  constexpr double kMiB = 1 << 20;
  spdlog::info(
      "{}: merged {} contributions, {:.1f} MiB, in {:.2f} s; published {} states, the largest {:.1f} MiB, in {:.2f} s",
      job_.stored.id().value, run_->contributions, static_cast<double>(run_->contribution_bytes) / kMiB,
      run_->merging_seconds, run_->states, static_cast<double>(run_->largest_state) / kMiB, run_->publishing_seconds);
  if (run_->shards_offered > 0)
    spdlog::info("{}: of {} shards of advances that took long, workers did {}", job_.stored.id().value,
                 run_->shards_offered, run_->shards_taken);
  farm_.CloseRounds(job_, [](const OpenRound&) { return true; });
  job_.run = nullptr;
  farm_.Pump(&deferred);
}

// Once an iteration: the canonical bytes, and their hash.
void Farm::FarmExecutor::Publish(const std::shared_ptr<const State>& state) {
  const auto start = Clock::Steady().Now();
  auto bytes = std::make_shared<const Bytes>(state->Serialize());
  const ContentHash hash = Sha256(*bytes);
  std::lock_guard lock(farm_.mutex_);
  run_->state = state;
  run_->state_hash = hash;
  ++run_->states;
  run_->largest_state = std::max<uint64_t>(run_->largest_state, bytes->size());
  run_->state_bytes = std::move(bytes);
  run_->publishing_seconds += Seconds(Clock::Steady().Now() - start);
  published_ = run_->busy.Now();
  ended_.reset();
}

void Farm::FarmExecutor::Run(ShardedWork& work) {
  const auto table = std::make_shared<ShardTable>(work, kMaxShardBytes);
  // Of a state that was restored at its iteration's end nothing is known.
  const Clock::Duration alone_until =
      ended_
          ? *ended_ + std::chrono::duration_cast<Clock::Duration>(farm_.options_.alone_share * (*ended_ - published_))
          : Clock::Duration::max();
  std::atomic<bool> offered = false;
  struct Withdraw {
    FarmExecutor& executor;
    ShardTable& table;
    ~Withdraw() {
      Deferred deferred;
      std::lock_guard lock(executor.farm_.mutex_);
      JobRun& run = *executor.run_;
      if (!std::exchange(run.shards, nullptr)) return;
      run.shards_offered += table.count();
      run.shards_taken += table.accepted();
      executor.farm_.Revoke(table.TakeVoid());
      executor.farm_.Pump(&deferred);
    }
  } withdraw{*this, *table};
  table->Run([&] {
    if (offered || run_->busy.Now() <= alone_until || offered.exchange(true)) return;
    Deferred deferred;
    std::lock_guard lock(farm_.mutex_);
    run_->shards = table;
    farm_.Pump(&deferred);
  });
}

std::shared_ptr<OpenRound> Farm::FarmExecutor::NewRound(const Round& round) const {
  return std::make_shared<OpenRound>(run_->state_hash, RoundReduction(*run_->method, run_->state, run_->grid, round),
                                     round, farm_.options_.leases, farm_.clock_, run_->busy);
}

// What the last checkpoint held of this round.
void Farm::FarmExecutor::Resume(OpenRound* open) {
  if (resumed_.nodes.empty()) return;
  if (resumed_.round == open->round && resumed_.state == open->state_hash) {
    open->reduction.Commit(resumed_.nodes, resumed_.merged);
    for (const TreeNode node : resumed_.nodes) open->leases.Commit(node);
    spdlog::info("{} resumes with {} of {} units of its round", job_.stored.id().value,
                 open->reduction.committed_units(), open->round.unit_count);
  }
  resumed_ = {};
}

std::optional<Contribution> Farm::FarmExecutor::Execute(const std::shared_ptr<const State>& state, const Round& round,
                                                        const StopToken& stop) {
  // Step 1: the state, where it is a new one.
  if (run_->state != state) {
    {
      std::lock_guard lock(farm_.mutex_);
      farm_.CloseRounds(job_, [](const OpenRound&) { return true; });
    }
    Publish(state);
  }
  // Step 2: the round, and the one that may follow it, are open; others are void. From here on it is workers who work.
  struct Waiting {
    explicit Waiting(BusyClock& of) : busy(of) { busy.End(); }
    ~Waiting() { busy.Begin(); }
    BusyClock& busy;
  };
  std::optional<Waiting> waiting;
  std::shared_ptr<OpenRound> current;
  const auto announced = std::exchange(announced_, std::nullopt);
  {
    Deferred deferred;
    std::lock_guard lock(farm_.mutex_);
    farm_.CloseRounds(
        job_, [&](const OpenRound& open) { return open.round != round && (!announced || open.round != *announced); });
    const auto find = [&](const Round& wanted) {
      const auto it =
          std::find_if(run_->open.begin(), run_->open.end(), [&](const auto& open) { return open->round == wanted; });
      return it == run_->open.end() ? nullptr : *it;
    };
    current = find(round);
    if (!current) {
      current = NewRound(round);
      Resume(current.get());
    }
    std::shared_ptr<OpenRound> next;
    if (announced && !(next = find(*announced))) next = NewRound(*announced);
    run_->open = {current};
    if (next) run_->open.push_back(next);
    waiting.emplace(run_->busy);
    farm_.Pump(&deferred);
  }
  // Step 3: until workers have covered it.
  checkpoint_(current.get());
  std::unique_lock lock(farm_.mutex_);
  while (!current->leases.complete() && !stop.Requested() && !farm_.ending_) {
    farm_.changed_.wait_for(lock, std::chrono::milliseconds(500));
    if (current->leases.complete()) break;
    lock.unlock();
    checkpoint_(current.get());
    lock.lock();
  }
  if (!current->leases.complete()) {
    const bool ending = farm_.ending_;
    lock.unlock();
    if (ending) checkpoint_(current.get());
    return std::nullopt;
  }
  std::erase(run_->open, current);
  waiting.reset();
  ended_ = run_->busy.Now();
  lock.unlock();
  std::lock_guard merge(current->merge);
  return current->reduction.Take();
}

void Farm::CloseRounds(Job& job, const std::function<bool(const OpenRound&)>& which) {
  if (!job.run) return;
  auto& open = job.run->open;
  for (auto it = open.begin(); it != open.end();) {
    if (!which(**it)) {
      ++it;
      continue;
    }
    std::vector<LeaseEntry> leases;
    for (const auto& [id, lease] : (*it)->leases.leases()) leases.push_back(lease);
    Revoke(leases);
    it = open.erase(it);
  }
}

}  // namespace lodestar
