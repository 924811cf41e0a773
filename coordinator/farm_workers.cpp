// What workers ask of the farm: leases; and what time brings.
#include "coordinator/farm.h"
#include "core/base/log.h"
#include "rpc/status.h"

namespace lodestar {
namespace {
constexpr uint32_t kMaxSurveysAtOnce = 64;
}

Registration Farm::Register(const WorkerInfo& info) {
  if (info.protocol_version != kProtocolVersion) {
    throw ProtocolError("worker '" + info.name + "' speaks protocol " + std::to_string(info.protocol_version) +
                        ", this coordinator " + std::to_string(kProtocolVersion) +
                        ": install the same release on both");
  }
  Deferred deferred;
  std::lock_guard lock(mutex_);
  WorkerId id{"worker-" + std::to_string(store_.epoch()) + "-" + std::to_string(++last_worker_)};
  Worker worker;
  worker.info = info;
  worker.fingerprint = info.Fingerprint();
  worker.seen = clock_.Now();
  workers_.emplace(id, std::move(worker));
  spdlog::info("{} ({}, {} threads) registered", id.value, info.name, info.threads);
  for (const Job* job : order_) Changed(*job, &deferred);
  return {id, store_.epoch(), options_.leases.duration};
}

LeasedUnit Farm::UnitOf(const Job& job, LeaseId lease) const {
  LeasedUnit unit;
  unit.id = lease;
  unit.job = job.stored.id();
  unit.description = job.stored.description;
  unit.duration = options_.leases.duration;
  return unit;
}

// All idle workers survey a new job at once: the first answer counts, and the others have the scene ready when its
// rounds begin.
std::optional<LeasedUnit> Farm::GrantSurvey(const WorkerId& id) {
  for (Job* job : order_) {
    if (job->stored.phase != JobPhase::kQueued || !job->stored.survey.empty() || job->cancelled ||
        job->asked.contains(id) || LeftToOthers(*job, id))
      continue;
    if (job->surveys.size() >= kMaxSurveysAtOnce) continue;
    const LeaseId lease = NewLeaseId();
    job->asked.insert(id);
    job->surveys.emplace(lease, SurveyLease{id, clock_.Now() + options_.leases.duration});
    return UnitOf(*job, lease);
  }
  return std::nullopt;
}

// What keeps a job's other workers waiting comes before its rounds, and before those of any other job.
std::optional<LeasedUnit> Farm::GrantShard(const WorkerId& id, const Worker& worker) {
  if (worker.info.tree_canary != tree_canary_) return std::nullopt;
  for (Job* job : order_) {
    if (!job->run || !job->run->shards || job->stop.Requested() || LeftToOthers(*job, id)) continue;
    const LeaseId lease = NewLeaseId();
    if (!job->run->shards->Grant(lease, id)) continue;
    LeasedUnit unit = UnitOf(*job, lease);
    unit.shard.emplace();
    return unit;
  }
  return std::nullopt;
}

std::shared_ptr<ShardTable> Farm::ShardsOf(const JobId& id) const {
  const Job& job = Need(id);
  return job.run ? job.run->shards : nullptr;
}

void Farm::AnswerLease(const LeaseAnswer& answer, std::optional<LeasedUnit> unit) {
  if (unit && unit->shard) {
    std::shared_ptr<ShardTable> shards;
    {
      std::lock_guard lock(mutex_);
      shards = ShardsOf(unit->job);
    }
    try {
      if (shards) unit->shard->request = shards->Describe(unit->id);
    } catch (const std::exception& error) {
      spdlog::warn("{}: a shard is not given out: {}", unit->job.value, error.what());
      shards->Release(unit->id);
    }
    if (unit->shard->request.empty()) unit.reset();  // it is over: the worker asks again
  }
  answer(std::move(unit));
}

std::optional<LeasedUnit> Farm::GrantRender(const WorkerId& id, const Worker& worker, bool copies, Speeds* speeds) {
  for (Job* job : order_) {
    if (!job->run || job->stored.fingerprint != worker.fingerprint || job->stop.Requested() || LeftToOthers(*job, id))
      continue;
    JobRun& run = *job->run;
    const auto pass_seconds = [&](const WorkerId& of) {
      const auto own = run.pass_seconds.find(of);
      return own != run.pass_seconds.end() ? own->second : run.mean_pass_seconds;
    };
    const auto speed = [&](const WorkerId& of) { return run.mean_pass_seconds > 0 ? 1 / pass_seconds(of) : 1; };
    const auto share = [&] {
      const auto [all, first] = speeds->try_emplace(job, 0);
      if (first) {
        for (const auto& [other, of] : workers_)
          if (of.fingerprint == job->stored.fingerprint) all->second += speed(other);
      }
      return speed(id) / all->second;
    };
    for (size_t i = 0; i < run.open.size(); ++i) {
      OpenRound& open = *run.open[i];
      std::optional<LeaseEntry> entry;
      if (copies) {
        entry = open.leases.GrantCopy(NewLeaseId(), id, run.mean_pass_seconds * open.round.passes);
      } else if (open.leases.free_units() > 0) {
        open.leases.set_bytes_per_unit(run.bytes_per_unit);
        const uint32_t units = LeaseUnits(open.leases.free_units(), open.leases.unit_count(), share(),
                                          pass_seconds(id) * open.round.passes, i + 1 < run.open.size());
        entry = open.leases.Grant(NewLeaseId(), id, units);
      }
      if (!entry) continue;
      LeasedUnit unit = UnitOf(*job, entry->id);
      unit.render = RenderUnit{open.round, entry->node, open.state_hash, job->stored.survey};
      return unit;
    }
  }
  return std::nullopt;
}

std::optional<LeasedUnit> Farm::GrantFor(const WorkerId& id, Speeds* speeds) {
  const auto it = workers_.find(id);
  if (it == workers_.end()) return std::nullopt;
  if (auto unit = GrantSurvey(id)) return unit;
  if (auto unit = GrantShard(id, it->second)) return unit;
  if (auto unit = GrantRender(id, it->second, false, speeds)) return unit;
  return GrantRender(id, it->second, true, speeds);
}

void Farm::Pump(Deferred* deferred) {
  Speeds speeds;
  for (auto it = parked_leases_.begin(); it != parked_leases_.end();) {
    if (auto unit = GrantFor(it->worker, &speeds)) {
      deferred->Add([this, answer = std::move(it->answer), unit = std::move(unit)] { AnswerLease(answer, unit); });
      it = parked_leases_.erase(it);
    } else {
      ++it;
    }
  }
  for (auto it = parked_renewals_.begin(); it != parked_renewals_.end();) {
    auto worker = workers_.find(it->worker);
    if (worker != workers_.end() && !worker->second.revoked.empty()) {
      deferred->Add([answer = std::move(it->answer), revoked = std::move(worker->second.revoked)] { answer(revoked); });
      worker->second.revoked.clear();
      it = parked_renewals_.erase(it);
    } else {
      ++it;
    }
  }
}

uint64_t Farm::Lease(const WorkerId& worker, Clock::Duration wait, LeaseAnswer answer) {
  Deferred deferred;
  std::lock_guard lock(mutex_);
  NeedWorker(worker);
  Speeds speeds;
  if (auto unit = GrantFor(worker, &speeds); unit || ending_) {
    deferred.Add([this, answer = std::move(answer), unit = std::move(unit)] { AnswerLease(answer, unit); });
    return 0;
  }
  parked_leases_.push_back({++last_call_, worker, clock_.Now() + wait, std::move(answer)});
  timer_wake_.notify_all();
  return last_call_;
}

uint64_t Farm::RenewLease(const WorkerId& id, const std::vector<LeaseId>& leases, Clock::Duration wait,
                          RenewAnswer answer) {
  Deferred deferred;
  std::lock_guard lock(mutex_);
  Worker& worker = NeedWorker(id);
  std::vector<LeaseId> revoked = std::move(worker.revoked);
  worker.revoked.clear();
  for (const LeaseId lease : leases) {
    bool held = false;
    for (Job* job : order_) {
      if (const auto it = job->surveys.find(lease); it != job->surveys.end() && it->second.worker == id) {
        it->second.expires = clock_.Now() + options_.leases.duration;
        held = true;
      }
      if (!job->run) continue;
      for (const auto& open : job->run->open) held = held || open->leases.Renew(lease, id);
      held = held || (job->run->shards && job->run->shards->Holds(lease));
    }
    if (!held) revoked.push_back(lease);
  }
  if (!revoked.empty() || ending_) {
    deferred.Add([answer = std::move(answer), revoked = std::move(revoked)] { answer(revoked); });
    return 0;
  }
  parked_renewals_.push_back({++last_call_, id, clock_.Now() + wait, std::move(answer)});
  return last_call_;
}

void Farm::Withdraw(uint64_t call) {
  std::lock_guard lock(mutex_);
  const auto withdrawn = [&](const auto& parked) { return parked.call == call; };
  parked_leases_.remove_if(withdrawn);
  parked_renewals_.remove_if(withdrawn);
}

void Farm::Revoke(const std::vector<LeaseEntry>& leases) {
  for (const auto& lease : leases) {
    const auto it = workers_.find(lease.worker);
    if (it != workers_.end()) it->second.revoked.push_back(lease.id);
  }
}

std::shared_ptr<const Bytes> Farm::StateBytes(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  for (const Job* job : order_) {
    if (job->run && job->run->state_hash == hash) return job->run->state_bytes;
  }
  throw Error(ErrorKind::kNotFound, "state " + hash.hex.substr(0, 80) + " is over");
}

// ---- time ----

void Farm::Tick(Deferred* deferred) {
  const auto now = clock_.Now();
  // Step 1: parked calls whose time is over; a parked call is a sign of life.
  const auto expire_parked = [&](auto& parked) {
    for (auto it = parked.begin(); it != parked.end();) {
      if (const auto worker = workers_.find(it->worker); worker != workers_.end()) worker->second.seen = now;
      if (it->until > now) {
        ++it;
        continue;
      }
      deferred->Add([answer = std::move(it->answer)] { answer({}); });
      it = parked.erase(it);
    }
  };
  expire_parked(parked_leases_);
  expire_parked(parked_renewals_);
  // Step 2: workers that are gone.
  for (auto it = workers_.begin(); it != workers_.end();) {
    if (now - it->second.seen > 2 * options_.leases.duration) {
      spdlog::warn("{} ({}) has not been heard of for {:.0f} s: given up", it->first.value, it->second.info.name,
                   Seconds(now - it->second.seen));
      it = workers_.erase(it);
    } else {
      ++it;
    }
  }
  // Step 3: leases that nobody renews.
  for (Job* job : order_) {
    for (auto it = job->surveys.begin(); it != job->surveys.end();) {
      if (it->second.expires > now) {
        ++it;
        continue;
      }
      const WorkerId lost = it->second.worker;
      job->asked.erase(lost);
      it = job->surveys.erase(it);
      CountLoss(*job, lost);
    }
    if (!job->run) continue;
    for (const auto& open : job->run->open) {
      const auto expired = open->leases.Expire();
      Revoke(expired);
      for (const auto& lease : expired) CountLoss(*job, lease.worker);
    }
  }
  Pump(deferred);
}

}  // namespace lodestar
