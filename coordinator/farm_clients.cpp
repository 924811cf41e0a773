// What clients ask of the farm.
#include <algorithm>

#include "coordinator/crash_point.h"
#include "coordinator/farm.h"
#include "core/base/log.h"
#include "core/learning/guide_file.h"
#include "rpc/image_bytes.h"
#include "rpc/status.h"

namespace lodestar {
namespace {

// All that is knowable of a job's scene before it is surveyed.
Survey SomeSurvey(const JobSpec& spec) {
  Survey survey;
  survey.bounds = Bounds3{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
  survey.resolution_x = spec.resolution_x ? spec.resolution_x : 16;
  survey.resolution_y = spec.resolution_y ? spec.resolution_y : 16;
  survey.max_depth = spec.max_depth ? spec.max_depth : 5;
  return survey;
}

}  // namespace

void Farm::CheckJob(const JobSpec& spec, const Survey& survey) const {
  const uint64_t films = Loop::FilmBytes(spec, survey);
  // The other half is for checkpoints, which copy them, and for other jobs.
  if (films <= options_.memory_bytes / 2) return;
  throw ExhaustedError("the films of a picture of " + std::to_string(survey.resolution_x) + "x" +
                       std::to_string(survey.resolution_y) + " pixels take " + std::to_string(films >> 20) +
                       " MiB, more than half of the " + std::to_string(options_.memory_bytes >> 20) +
                       " MiB that the coordinator may use; try a smaller --resolution, 'lodestar render' on a machine "
                       "with more memory, or give the coordinator more");
}

JobId Farm::Submit(const JobSubmission& submission) {
  submission.scene.Validate();
  CheckJob(submission.spec, SomeSurvey(submission.spec));
  blobs_->CheckSpace(16 << 20);
  {
    std::lock_guard lock(mutex_);
    for (const auto& [number, job] : jobs_) {
      if (job->stored.client_token == submission.client_token) return job->stored.id();
    }
    if (order_.size() >= options_.max_queued) {
      throw ExhaustedError("the queue is full (" + std::to_string(order_.size()) +
                           " jobs): wait until some have ended, or cancel some");
    }
  }
  StoredJob stored;
  stored.client_token = submission.client_token;
  stored.name = submission.name;
  stored.scene_path = submission.scene_path;
  stored.priority = submission.priority;
  stored.submitted_unix_ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count();
  stored.description = blobs_->Put(JobDescription{submission.spec, submission.scene, submission.threads}.Serialize());
  stored.reference = submission.reference;
  std::vector<ContentHash> assets{stored.description};
  if (!stored.reference.empty()) assets.push_back(stored.reference);
  for (const auto& [name, file] : submission.scene.files) assets.push_back(file.hash);
  stored = store_.Insert(stored, assets);
  CrashPoint("job-committed");
  Deferred deferred;
  std::lock_guard lock(mutex_);
  if (!jobs_.contains(stored.number)) {  // the same token may have come twice at once
    auto job = std::make_unique<Job>();
    job->stored = stored;
    job->spec = submission.spec;
    jobs_.emplace(stored.number, std::move(job));
    spdlog::info("{} ({}) submitted: {}", stored.id().value, stored.name, submission.spec.method);
    Reorder();
    Pump(&deferred);
  }
  return stored.id();
}

JobStatus Farm::Get(const JobId& id) const {
  std::lock_guard lock(mutex_);
  return Status(Need(id));
}

std::vector<JobStatus> Farm::List() const {
  std::lock_guard lock(mutex_);
  std::vector<JobStatus> all;
  for (auto it = jobs_.rbegin(); it != jobs_.rend() && all.size() < 1000; ++it) all.push_back(Status(*it->second));
  for (auto& status : all) {  // one message holds them all
    status.log.clear();
    status.scene_path.clear();
  }
  return all;
}

void Farm::Cancel(const JobId& id) {
  Job* job = nullptr;
  {
    std::lock_guard lock(mutex_);
    job = &Need(id);
    if (Ended(job->stored.phase) || job->cancelled) return;
    job->cancelled = true;
    job->Log("cancelled by a client");
    job->stop.Request();
    if (job->driving) {
      changed_.notify_all();
      return;  // the driver ends it, with the image so far
    }
  }
  EndJob(*job, JobPhase::kCancelled, "");
}

void Farm::AwaitSnapshot(Job& job, std::unique_lock<std::mutex>& lock) {
  if (!job.driving || job.progress.passes == 0) return;
  job.snapshot_wanted = true;
  const auto until = clock_.Now() + std::chrono::seconds(5);
  while (job.snapshot_wanted && job.driving && !ending_ && clock_.Now() < until)
    changed_.wait_for(lock, std::chrono::milliseconds(100));
}

std::shared_ptr<const Image> Farm::GetImage(const JobId& id) {
  std::unique_lock lock(mutex_);
  Job& job = Need(id);
  AwaitSnapshot(job, lock);
  if (job.stored.image.empty()) {
    if (job.image) return job.image;
    if (Ended(job.stored.phase)) {
      throw Error(ErrorKind::kConflict, id.value + " has no image: it ended before its first round was complete" +
                                            (job.stored.error.empty() ? "" : " (" + job.stored.error + ")"));
    }
    throw Error(ErrorKind::kConflict,
                id.value + " has no image yet: " +
                    (Status(job).waiting_for.empty() ? "its first round is not complete"
                                                     : "it waits for " + Status(job).waiting_for));
  }
  const ContentHash hash = job.stored.image;
  lock.unlock();
  return std::make_shared<const Image>(ImageFromBytes(Decompress(blobs_->Read(hash), "stored image")));
}

std::string Farm::GetReport(const JobId& id) {
  std::unique_lock lock(mutex_);
  Job& job = Need(id);
  AwaitSnapshot(job, lock);
  if (!job.stored.report.empty()) return job.stored.report;
  if (job.report.empty())
    throw Error(ErrorKind::kConflict, id.value + " has not rendered a round yet, so there is nothing to report");
  return job.report;
}

Bytes Farm::GetGuide(const JobId& id) {
  std::unique_lock lock(mutex_);
  const Job& job = Need(id);
  if (job.driving && job.run && job.run->state && Learns(*job.run->method)) {
    GuideFile guide{job.spec, Survey::Parse(job.stored.survey), job.progress.iteration, {}, std::nullopt};
    const std::shared_ptr<const State> state = job.run->state;
    lock.unlock();
    guide.state = state->Serialize();
    return guide.Serialize();
  }
  if (!job.stored.guide.empty()) {
    const ContentHash hash = job.stored.guide;
    lock.unlock();
    return blobs_->Read(hash);
  }
  const bool over = Ended(job.stored.phase) || job.driving;
  throw Error(ErrorKind::kConflict,
              id.value + " has nothing learned" +
                  (over ? " to give: method '" + job.spec.method + "' learns nothing, or it ended early"
                        : " yet: it has not begun"));
}

std::vector<WorkerStatus> Farm::Workers() const {
  std::lock_guard lock(mutex_);
  std::map<WorkerId, uint32_t> leases;
  for (const Job* job : order_) {
    for (const auto& [id, survey] : job->surveys) ++leases[survey.worker];
    if (!job->run) continue;
    for (const auto& open : job->run->open) {
      for (const auto& [id, lease] : open->leases.leases()) ++leases[lease.worker];
    }
  }
  std::vector<WorkerStatus> all;
  for (const auto& [id, worker] : workers_) {
    WorkerStatus s;
    s.id = id;
    s.name = worker.info.name;
    s.threads = worker.info.threads;
    s.fingerprint = worker.fingerprint;
    s.leases = leases[id];
    s.units = worker.units;
    s.units_per_second = worker.seconds > 0 ? static_cast<double>(worker.units) / worker.seconds : 0;
    s.seconds_since_seen = Seconds(clock_.Now() - worker.seen);
    all.push_back(std::move(s));
  }
  return all;
}

uint64_t Farm::Watch(const JobId& id, std::function<void(const JobStatus&)> changed) {
  Deferred deferred;
  std::lock_guard lock(mutex_);
  const Job& job = Need(id);
  deferred.Add([changed, status = Status(job)] { changed(status); });
  watchers_.emplace(++last_call_, Watcher{job.stored.number, std::move(changed)});
  return last_call_;
}

void Farm::Unwatch(uint64_t watch) {
  std::lock_guard lock(mutex_);
  watchers_.erase(watch);
}

}  // namespace lodestar
