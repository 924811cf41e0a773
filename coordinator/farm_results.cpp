// What workers bring to the farm: contributions, surveys, failures.
#include "coordinator/crash_point.h"
#include "coordinator/farm.h"

namespace lodestar {

ContributionOutcome Farm::SubmitContribution(const ContributionHeader& header, std::string_view bytes) {
  // Step 1: is it of something that is still open?
  Job* job = nullptr;
  std::shared_ptr<JobRun> run;
  std::shared_ptr<OpenRound> open;
  {
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
  }
  // Step 2: decode and merge, beside everything else.
  RoundReduction::Outcome outcome;
  double merging_seconds = 0;
  {
    std::lock_guard merge(open->merge);
    const auto start = Clock::Steady().Now();
    outcome = open->reduction.Commit(header.nodes, bytes);
    merging_seconds = Seconds(Clock::Steady().Now() - start);
  }
  CrashPoint("contribution-merged");
  // Step 3: who need not work on it any more, and how fast this was.
  Deferred deferred;
  std::lock_guard lock(mutex_);
  for (const LeaseId lease : header.leases) open->leases.Release(lease);
  uint32_t units = 0;
  for (const TreeNode node : header.nodes) {
    if (outcome == RoundReduction::Outcome::kCommitted) Revoke(open->leases.Commit(node));
    units += node.end(open->round.unit_count) - node.first();
  }
  if (outcome == RoundReduction::Outcome::kCommitted) job->lost.clear();
  run->merging_seconds += merging_seconds;
  run->contribution_bytes += bytes.size();
  ++run->contributions;
  const auto mix = [](double old, double now, double share) { return old > 0 ? old + share * (now - old) : now; };
  if (header.seconds > 0) {
    const double pass = header.seconds / units / open->round.passes;
    double& own = run->pass_seconds[header.worker];
    own = mix(own, pass, 0.3);
    run->mean_pass_seconds = mix(run->mean_pass_seconds, pass, 0.2);
    if (auto it = workers_.find(header.worker); it != workers_.end()) {
      it->second.units += units;
      it->second.seconds += header.seconds;
    }
  }
  run->bytes_per_unit = mix(run->bytes_per_unit, static_cast<double>(bytes.size()) / units, 0.2);
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
    fingerprint = worker.fingerprint;
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
    CheckJob(job->spec, survey);
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

void Farm::SubmitShard(const ShardAnswer& answer) {
  std::shared_ptr<ShardTable> shards;
  {
    std::lock_guard lock(mutex_);
    Worker& worker = NeedWorker(answer.worker);
    worker.seen = clock_.Now();
    shards = ShardsOf(answer.job);
  }
  if (shards) shards->Accept(answer.lease, answer.trees);
}

void Farm::FailRunning(Job& job, const std::string& why) {
  job.failure = why;
  job.Log(why);
  job.stop.Request();
  changed_.notify_all();
}

void Farm::CountLoss(Job& job, const WorkerId& worker) {
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
                  "and submit it again to other machines");
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
      if (job.run->shards) job.run->shards->Release(failure.lease);
    }
    if (Ended(job.stored.phase) || !job.failure.empty()) return;  // it has its reason
    if (failure.kind != UnitFailure::Kind::kReturned) job.Log(worker.info.name + ": " + failure.message);
    if (failure.kind == UnitFailure::Kind::kJob) {
      FailRunning(job, failure.message);
    } else if (failure.kind == UnitFailure::Kind::kWorker) {
      // This worker's fault as it says; counted at once, each report its own event.
      job.last_loss = clock_.Now() - options_.leases.duration;
      job.gave_back.insert(failure.worker);
      job.lost.insert(WorkerId{failure.worker.value + "#" + std::to_string(failure.lease.value)});
      if (job.lost.size() >= static_cast<size_t>(options_.strikes)) FailRunning(job, failure.message);
    }
    if (surveying && job.failure.empty()) job.asked.erase(failure.worker);
    if (!job.failure.empty() && !job.driving) ended = &job;
    Pump(&deferred);
  }
  if (ended) EndJob(*ended, JobPhase::kFailed, ended->failure);
}

}  // namespace lodestar
