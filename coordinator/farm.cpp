#include "coordinator/farm.h"

#include <algorithm>

#include "coordinator/crash_point.h"
#include "core/base/log.h"
#include "core/guiding/tree_request.h"
#include "rpc/status.h"

namespace lodestar {
namespace {

// As it is stored; how long is left is for those who see it run.
Bytes SerializeProgress(const JobProgress& progress) {
  ByteWriter out;
  out.Put(progress.iteration);
  out.Put(progress.passes);
  out.Put(progress.seconds);
  out.Put(progress.relmse_estimated);
  out.Put(progress.fraction);
  out.Put(progress.rays);
  // Paths and vertices, which older coordinators read.
  out.Put(uint64_t{0});
  out.Put(uint64_t{0});
  return out.Take();
}

JobProgress ParseProgress(std::string_view bytes) {
  ByteReader in(bytes, "job progress");
  JobProgress progress;
  progress.iteration = in.Get<uint32_t>();
  progress.passes = in.Get<uint64_t>();
  progress.seconds = in.Get<double>();
  progress.relmse_estimated = in.Get<double>();
  progress.fraction = in.Get<double>();
  progress.rays = in.Get<uint64_t>();
  return progress;
}

}  // namespace

Farm::Farm(Options options)
    : options_(std::move(options)),
      clock_(*options_.clock),
      store_(options_.store, options_.fatal),
      tree_canary_(TreeCanary()) {
  blobs_ = std::make_unique<BlobStore>(options_.store / "blobs", store_, options_.blobs);
  Load();
  timer_ = std::thread([this] { TimerLoop(); });
}

Farm::~Farm() {
  std::vector<std::thread> drivers;
  {
    Deferred deferred;
    std::lock_guard lock(mutex_);
    ending_ = true;
    for (auto& [number, job] : jobs_) {
      job->stop.Request();
      if (job->driver.joinable()) drivers.push_back(std::move(job->driver));
    }
    const auto answer_all = [&](auto& parked) {
      for (auto& call : parked) deferred.Add([answer = std::move(call.answer)] { answer({}); });
      parked.clear();
    };
    answer_all(parked_leases_);
    answer_all(parked_renewals_);
    watchers_.clear();
  }
  changed_.notify_all();
  timer_wake_.notify_all();
  for (auto& driver : drivers) driver.join();
  timer_.join();
}

void Farm::Load() {
  for (auto& stored : store_.Jobs()) {
    auto job = std::make_unique<Job>();
    job->stored = stored;
    try {
      job->spec = JobDescription::Parse(blobs_->Read(stored.description)).spec;
      if (!stored.survey.empty()) {
        const auto survey = Survey::Parse(stored.survey);
        job->width = survey.resolution_x;
        job->height = survey.resolution_y;
      }
      if (!stored.progress.empty()) job->progress = ParseProgress(stored.progress);
    } catch (const Error& error) {
      spdlog::error("{}: {}", stored.id().value, error.what());
      if (!Ended(stored.phase)) {
        job->stored.phase = JobPhase::kFailed;
        job->stored.error = std::string("the coordinator has lost what it needs of this job: ") + error.what();
        store_.Update(job->stored);
      }
    }
    for (size_t at = 0; at < stored.log.size();) {
      const size_t end = std::min(stored.log.find('\n', at), stored.log.size());
      job->Log(stored.log.substr(at, end - at));
      at = end + 1;
    }
    jobs_.emplace(stored.number, std::move(job));
  }
  std::lock_guard lock(mutex_);
  Reorder();
  StartDrivers();
}

Job& Farm::Need(const JobId& id) const {
  if (id.value.starts_with("job-") && id.value.size() < 20) {
    const auto it = jobs_.find(std::atoll(id.value.c_str() + 4));
    if (it != jobs_.end() && it->second->stored.id() == id) return *it->second;
  }
  throw Error(ErrorKind::kNotFound,
              "there is no job '" + id.value.substr(0, 40) + "'; 'lodestar jobs' lists those there are");
}

Farm::Worker& Farm::NeedWorker(const WorkerId& id) {
  const auto it = workers_.find(id);
  if (it == workers_.end()) throw Error(ErrorKind::kNotFound, "unknown worker: register again");
  it->second.seen = clock_.Now();
  return it->second;
}

uint32_t Farm::LiveWorkers(const std::string& fingerprint) const {
  uint32_t count = 0;
  for (const auto& [id, worker] : workers_) count += fingerprint.empty() || worker.fingerprint == fingerprint;
  return count;
}

// A worker that has given a job's work back (its memory is too small, its disk full) gets none of it while there are
// others to ask.
bool Farm::LeftToOthers(const Job& job, const WorkerId& worker) const {
  if (!job.gave_back.contains(worker)) return false;
  return std::any_of(workers_.begin(), workers_.end(), [&](const auto& other) {
    return !job.gave_back.contains(other.first) &&
           (job.stored.fingerprint.empty() || other.second.fingerprint == job.stored.fingerprint);
  });
}

JobStatus Farm::Status(const Job& job) const {
  JobStatus s;
  s.id = job.stored.id();
  s.name = job.stored.name;
  s.scene_path = job.stored.scene_path;
  s.priority = job.stored.priority;
  s.method = job.spec.method;
  s.phase = job.stored.phase;
  s.error = job.stored.error;
  s.log.assign(job.log.begin(), job.log.end());
  s.submitted_unix_ms = job.stored.submitted_unix_ms;
  s.progress = job.progress;
  s.width = job.width;
  s.height = job.height;
  if (s.phase == JobPhase::kQueued) {
    if (!job.stored.survey.empty()) {
      s.waiting_for =
          job.driven ? "its first round" : "its turn: " + std::to_string(options_.max_running) + " jobs run at a time";
    } else {
      s.waiting_for = !job.surveys.empty() ? "the survey of its scene"
                      : workers_.empty()   ? "a worker: none is registered"
                                           : "a worker to survey its scene";
    }
  } else if (s.phase == JobPhase::kRunning && LiveWorkers(job.stored.fingerprint) == 0) {
    s.waiting_for = workers_.empty()
                        ? "a worker: none is registered"
                        : "a worker of the build that surveyed its scene: all those registered are of another";
  }
  return s;
}

void Farm::Changed(const Job& job, Deferred* deferred) {
  for (const auto& [id, watcher] : watchers_) {
    if (watcher.job == job.stored.number)
      deferred->Add([changed = watcher.changed, status = Status(job)] { changed(status); });
  }
}

void Farm::Reorder() {
  order_.clear();
  for (const auto& [number, job] : jobs_) {
    if (!Ended(job->stored.phase)) order_.push_back(job.get());
  }
  // Larger priorities first; older jobs first among equals, as they stand in jobs_.
  std::ranges::stable_sort(order_, std::greater<>(), [](const Job* job) { return job->stored.priority; });
}

void Farm::Persist(Job& job, const std::function<void(StoredJob&)>& change) {
  std::lock_guard order(job.persist);
  StoredJob copy;
  {
    std::lock_guard lock(mutex_);
    copy = job.stored;
    change(copy);
    copy.progress = SerializeProgress(job.progress);
    copy.log.clear();
    for (const auto& line : job.log) copy.log += (copy.log.empty() ? "" : "\n") + line;
  }
  store_.Update(copy);
  std::lock_guard lock(mutex_);
  job.stored = std::move(copy);
}

void Farm::PersistEnd(Job& job, const std::function<void(StoredJob&)>& change) {
  JobId id;
  ContentHash checkpoint;
  Persist(job, [&](StoredJob& stored) {
    change(stored);
    id = stored.id();
    checkpoint = std::exchange(stored.checkpoint, {});
  });
  CrashPoint("done-committed");
  if (checkpoint.empty()) return;
  try {
    blobs_->Drop(checkpoint);
  } catch (const Error& error) {
    spdlog::warn("{}: its last checkpoint is left to the next collection: {}", id.value, error.what());
  }
}

void Farm::EndJob(Job& job, JobPhase phase, const std::string& error) {
  std::string name;
  {
    std::lock_guard lock(mutex_);
    name = job.stored.id().value + " (" + job.stored.name + ")";
  }
  try {
    PersistEnd(job, [&](StoredJob& stored) {
      stored.phase = phase;
      stored.error = error;
    });
  } catch (const Error& store_error) {
    spdlog::error("{} has ended, which could not be stored: {}", name, store_error.what());
    std::lock_guard lock(mutex_);
    job.stored.phase = phase;
    job.stored.error = error;
  }
  spdlog::info("{} {}{}{}", name, JobPhaseName(phase), error.empty() ? "" : ": ", error);
  Deferred deferred;
  std::lock_guard lock(mutex_);
  job.surveys.clear();
  Reorder();
  StartDrivers();
  Changed(job, &deferred);
  Pump(&deferred);
  changed_.notify_all();
}

void Farm::StartDrivers() {
  if (ending_) return;
  const auto running = std::count_if(order_.begin(), order_.end(), [](const Job* job) { return job->driving; });
  auto room = static_cast<int64_t>(options_.max_running) - running;
  for (Job* job : order_) {
    if (room <= 0) break;
    if (job->driving || job->cancelled || job->stored.survey.empty()) continue;
    if (job->driven) continue;  // its driver has just ended
    job->driving = job->driven = true;
    job->driver = std::thread([this, job] { Drive(*job); });
    --room;
  }
}

void Farm::TimerLoop() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    // Copies for stragglers are the only answers that come with time alone, so parked workers make it tick faster.
    const bool busy = !parked_leases_.empty();
    timer_wake_.wait_for(lock, busy ? std::chrono::milliseconds(25) : std::chrono::milliseconds(200),
                         [&] { return ending_; });
    lock.unlock();
    bool collect = false;
    std::vector<std::thread> over;
    std::vector<Job*> failed;
    {
      Deferred deferred;
      std::lock_guard guard(mutex_);
      if (!ending_) {
        Tick(&deferred);
        for (auto& [number, job] : jobs_) {
          if (!job->driving && job->driver.joinable()) over.push_back(std::move(job->driver));
          if (!job->driven && !job->failure.empty() && !Ended(job->stored.phase)) failed.push_back(job.get());
        }
        if (clock_.Now() >= next_collection_) {
          collect = true;
          next_collection_ = clock_.Now() + std::chrono::minutes(5);
        }
      }
    }
    for (auto& driver : over) driver.join();
    for (Job* job : failed) EndJob(*job, JobPhase::kFailed, job->failure);
    if (collect) {
      (void)Guarded([&] {
        if (const size_t count = blobs_->Collect()) spdlog::info("collected {} unused blobs", count);
      });
    }
    lock.lock();
  }
}

}  // namespace lodestar
