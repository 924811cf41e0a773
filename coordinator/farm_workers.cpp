// What workers ask of the farm: leases out, results in.
#include <algorithm>

#include "coordinator/crash_point.h"
#include "coordinator/farm.h"
#include "core/base/log.h"
#include "core/learning/contribution.h"
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
  worker.seen = clock_.Now();
  workers_.emplace(id, std::move(worker));
  spdlog::info("{} ({}, {} threads) registered", id.value, info.name, info.threads);
  for (const Job* job : order_) Changed(*job, &deferred);
  return {id, store_.epoch(), options_.leases.duration};
}

LeasedUnit Farm::Describe(const Job& job, const LeaseEntry& entry, const OpenRound& open) const {
  LeasedUnit unit;
  unit.id = entry.id;
  unit.job = job.stored.id();
  unit.description = job.stored.description;
  unit.duration = options_.leases.duration;
  unit.render = RenderUnit{open.round, entry.node, open.state_hash, job.stored.survey};
  return unit;
}

// All idle workers survey a new job at once: the first answer counts, and the others have the scene ready when its
// rounds begin.
std::optional<LeasedUnit> Farm::GrantSurvey(const WorkerId& id, const Worker& worker) {
  for (Job* job : order_) {
    if (job->stored.phase != JobPhase::kQueued || !job->stored.survey.empty() || job->cancelled ||
        job->asked.contains(id))
      continue;
    if (job->surveys.size() >= kMaxSurveysAtOnce) continue;
    const LeaseId lease = NewLeaseId();
    job->asked.insert(id);
    job->surveys.emplace(lease, SurveyLease{id, clock_.Now() + options_.leases.duration});
    LeasedUnit unit;
    unit.id = lease;
    unit.job = job->stored.id();
    unit.description = job->stored.description;
    unit.duration = options_.leases.duration;
    return unit;
  }
  return std::nullopt;
}

std::optional<LeasedUnit> Farm::GrantRender(const WorkerId& id, const Worker& worker, bool copies) {
  for (Job* job : order_) {
    if (!job->run || job->stored.fingerprint != worker.info.Fingerprint() || job->stop.Requested()) continue;
    JobRun& run = *job->run;
    const auto own = run.seconds_per_unit.find(id);
    const double speed = own != run.seconds_per_unit.end() ? own->second : run.mean_seconds_per_unit;
    for (size_t i = 0; i < run.open.size(); ++i) {
      OpenRound& open = *run.open[i];
      std::optional<LeaseEntry> entry;
      if (copies) {
        entry = open.leases.GrantCopy(NewLeaseId(), id, run.mean_seconds_per_unit);
      } else {
        open.leases.set_bytes_per_unit(run.bytes_per_unit);
        const uint32_t units = LeaseUnits(options_.sizing, open.leases.free_units(), open.leases.unit_count(),
                                          LiveWorkers(job->stored.fingerprint), speed, i + 1 < run.open.size());
        entry = open.leases.Grant(NewLeaseId(), id, units);
      }
      if (entry) return Describe(*job, *entry, open);
    }
  }
  return std::nullopt;
}

std::optional<LeasedUnit> Farm::GrantFor(const WorkerId& id) {
  const auto it = workers_.find(id);
  if (it == workers_.end()) return std::nullopt;
  if (auto unit = GrantSurvey(id, it->second)) return unit;
  if (auto unit = GrantRender(id, it->second, false)) return unit;
  return GrantRender(id, it->second, true);
}

void Farm::Pump(Deferred* deferred) {
  for (auto it = parked_leases_.begin(); it != parked_leases_.end();) {
    if (auto unit = GrantFor(it->worker)) {
      deferred->Add([answer = std::move(it->answer), unit = std::move(unit)] { answer(unit); });
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
  if (auto unit = GrantFor(worker); unit || ending_) {
    deferred.Add([answer = std::move(answer), unit = std::move(unit)] { answer(unit); });
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
  parked_leases_.remove_if([&](const ParkedLease& parked) { return parked.call == call; });
  parked_renewals_.remove_if([&](const ParkedRenewal& parked) { return parked.call == call; });
}

void Farm::Revoke(const std::vector<LeaseEntry>& leases, Deferred* deferred) {
  for (const auto& lease : leases) {
    const auto it = workers_.find(lease.worker);
    if (it != workers_.end()) it->second.revoked.push_back(lease.id);
  }
}

std::shared_ptr<const Bytes> Farm::CompressedState(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  for (const Job* job : order_) {
    if (job->run && job->run->state_hash == hash) return job->run->state_compressed;
  }
  throw Error(ErrorKind::kNotFound, "state " + hash.hex.substr(0, 80) + " is over");
}

ContributionOutcome Farm::SubmitContribution(const ContributionHeader& header, std::string_view compressed) {
  // Step 1: is it of something that is still open?
  Job* job = nullptr;
  std::shared_ptr<JobRun> run;
  std::shared_ptr<OpenRound> open;
  {
    Deferred deferred;
    std::lock_guard lock(mutex_);
    if (auto it = workers_.find(header.worker); it != workers_.end()) it->second.seen = clock_.Now();
    try {
      job = &Need(header.job);
    } catch (const Error&) {
      return ContributionOutcome::kJobEnded;
    }
    if (Ended(job->stored.phase)) return ContributionOutcome::kJobEnded;
    run = job->run;
    if (!run) return ContributionOutcome::kStale;
    for (const auto& candidate : run->open) {
      if (candidate->round == header.round && candidate->state_hash == header.state) open = candidate;
    }
    if (!open) return ContributionOutcome::kStale;
    if (!header.node.ValidIn(open->round.unit_count))
      throw Error(ErrorKind::kInvalidInput, header.node.ToString() + " does not exist in its round");
    if (open->leases.Covered(header.node)) {
      open->leases.Release(header.lease);
      return ContributionOutcome::kCovered;
    }
  }
  // Step 2: decode and merge, beside everything else.
  const std::string what = "the contribution of " + header.node.ToString();
  const Bytes bytes = Decompress(compressed, what, header.size);
  if (bytes.size() != header.size || Sha256(bytes) != header.hash)
    throw Error(ErrorKind::kCorrupt, what + " came damaged: its hash is another");
  Contribution contribution = ParseContribution(run->method, open->state, run->grid, open->round, header.node, bytes);
  RoundReduction::Outcome outcome;
  {
    std::lock_guard merge(open->merge);
    outcome = open->reduction.Commit(header.node, std::move(contribution));
  }
  CrashPoint("contribution-merged");
  // Step 3: who need not work on it any more, and how fast this was.
  Deferred deferred;
  std::lock_guard lock(mutex_);
  open->leases.Release(header.lease);
  Revoke(open->leases.Commit(header.node), &deferred);
  job->lost.clear();
  const uint32_t units = header.node.end(open->round.unit_count) - header.node.first();
  if (header.seconds > 0) {
    const double speed = header.seconds / units;
    auto [own, first] = run->seconds_per_unit.emplace(header.worker, speed);
    if (!first) own->second = 0.7 * own->second + 0.3 * speed;
    run->mean_seconds_per_unit =
        run->mean_seconds_per_unit > 0 ? 0.8 * run->mean_seconds_per_unit + 0.2 * speed : speed;
    if (auto it = workers_.find(header.worker); it != workers_.end()) {
      it->second.units += units;
      it->second.seconds += header.seconds;
    }
  }
  run->bytes_per_unit = 0.8 * run->bytes_per_unit + 0.2 * static_cast<double>(bytes.size()) / units;
  if (open->leases.complete()) changed_.notify_all();
  Pump(&deferred);
  return outcome == RoundReduction::Outcome::kCommitted ? ContributionOutcome::kCommitted
                                                        : ContributionOutcome::kCovered;
}

void Farm::SubmitSurvey(const SurveyResult& result) {
  Job* job = nullptr;
  std::string fingerprint;
  {
    std::lock_guard lock(mutex_);
    Worker& worker = NeedWorker(result.worker);
    fingerprint = worker.info.Fingerprint();
    job = &Need(result.job);
    job->surveys.erase(result.lease);
    if (job->stored.phase != JobPhase::kQueued || !job->stored.survey.empty() || job->cancelled)
      return;  // another was first
    for (const auto& line : result.log) job->Log(worker.info.name + ": " + line);
    if (!result.scene_error.empty()) job->Log(worker.info.name + ": " + result.scene_error);
  }
  if (!result.scene_error.empty()) return EndJob(*job, JobPhase::kFailed, result.scene_error);
  Survey survey;
  try {
    survey = Survey::Parse(result.survey);
    (void)Loop(job->spec, survey);
  } catch (const Error& error) {
    return EndJob(*job, JobPhase::kFailed, error.what());
  }
  Persist(*job, [&](StoredJob& stored) {
    if (!stored.survey.empty()) return;
    stored.survey = result.survey;
    stored.fingerprint = fingerprint;
  });
  CrashPoint("survey-committed");
  Deferred deferred;
  std::lock_guard lock(mutex_);
  job->width = survey.resolution_x;
  job->height = survey.resolution_y;
  StartDrivers();
  Changed(*job, &deferred);
}

void Farm::FailRunning(Job& job, const std::string& why, Deferred* deferred) {
  job.failure = why;
  job.Log(why);
  job.stop.Request();
  changed_.notify_all();
}

void Farm::CountLoss(Job& job, const WorkerId& worker, Deferred* deferred) {
  // Losses within one lease's duration are one event (a switch, a power cut), and no scene's fault where no worker is
  // left.
  const auto now = clock_.Now();
  if (workers_.empty() || (!job.lost.empty() && now - job.last_loss < options_.leases.duration)) return;
  job.lost.insert(worker);
  job.last_loss = now;
  const auto known = workers_.find(worker);
  job.Log("lost " + worker.value + (known != workers_.end() ? " (" + known->second.info.name + ")" : "") +
          " while it worked on this job");
  if (job.lost.size() < static_cast<size_t>(options_.strikes) || !job.failure.empty()) return;
  FailRunning(job,
              std::to_string(job.lost.size()) +
                  " workers were lost on this job and nothing was finished in between: its scene may need more memory "
                  "than they have; see their logs, " +
                  "and submit it again to other machines",
              deferred);
}

void Farm::ReportFailure(const UnitFailure& failure) {
  Job* ended = nullptr;
  {
    Deferred deferred;
    std::lock_guard lock(mutex_);
    Worker& worker = NeedWorker(failure.worker);
    Job& job = Need(failure.job);
    const bool surveying = job.surveys.erase(failure.lease) > 0;
    if (job.run) {
      for (const auto& open : job.run->open) open->leases.Release(failure.lease);
    }
    if (Ended(job.stored.phase)) return;
    if (failure.kind != UnitFailure::Kind::kReturned) job.Log(worker.info.name + ": " + failure.message);
    if (failure.kind == UnitFailure::Kind::kJob) {
      FailRunning(job, failure.message, &deferred);
    } else if (failure.kind == UnitFailure::Kind::kWorker) {
      // This worker's fault as it says; counted at once, each report its own event.
      job.last_loss = clock_.Now() - options_.leases.duration;
      job.lost.insert(WorkerId{failure.worker.value + "#" + std::to_string(failure.lease.value)});
      if (job.lost.size() >= static_cast<size_t>(options_.strikes)) FailRunning(job, failure.message, &deferred);
    }
    if (surveying && job.failure.empty()) job.asked.erase(failure.worker);
    if (!job.failure.empty() && !job.driving) ended = &job;
    Pump(&deferred);
  }
  if (ended) EndJob(*ended, JobPhase::kFailed, ended->failure);
}

// ---- time
// ------------------------------------------------------------------------------------------------------------------------------------

void Farm::Tick(Deferred* deferred) {
  const auto now = clock_.Now();
  // Step 1: parked calls whose time is over; a parked call is a sign of life.
  const auto alive = [&](const WorkerId& id) {
    if (auto it = workers_.find(id); it != workers_.end()) it->second.seen = now;
  };
  for (auto it = parked_leases_.begin(); it != parked_leases_.end();) {
    alive(it->worker);
    if (it->until > now) {
      ++it;
      continue;
    }
    deferred->Add([answer = std::move(it->answer)] { answer(std::nullopt); });
    it = parked_leases_.erase(it);
  }
  for (auto it = parked_renewals_.begin(); it != parked_renewals_.end();) {
    alive(it->worker);
    if (it->until > now) {
      ++it;
      continue;
    }
    deferred->Add([answer = std::move(it->answer)] { answer({}); });
    it = parked_renewals_.erase(it);
  }
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
      CountLoss(*job, lost, deferred);
    }
    if (!job->run) continue;
    for (const auto& open : job->run->open) {
      const auto expired = open->leases.Expire();
      Revoke(expired, deferred);
      for (const auto& lease : expired) CountLoss(*job, lease.worker, deferred);
    }
  }
  Pump(deferred);
}

}  // namespace lodestar
