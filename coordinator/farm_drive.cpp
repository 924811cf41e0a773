// A job's driver thread: the loop over leases, its checkpoints, its end.
#include <future>
#include <nlohmann/json.hpp>

#include "coordinator/crash_point.h"
#include "coordinator/farm_executor.h"
#include "core/base/log.h"
#include "core/learning/contribution.h"
#include "core/learning/guide_file.h"
#include "core/learning/report_json.h"
#include "rpc/image_bytes.h"

namespace lodestar {
namespace {

// Where the last checkpoint left off; nothing where there is none, or none that can be read: then the job is rendered
// again, with the same bits.
std::unique_ptr<Loop> Restored(const BlobStore& blobs, const StoredJob& stored, JobCheckpoint* checkpoint) {
  if (stored.checkpoint.empty()) return nullptr;
  try {
    *checkpoint = JobCheckpoint::Parse(blobs.Read(stored.checkpoint));
    return Loop::Restore(checkpoint->loop);
  } catch (const Error& error) {
    spdlog::warn("{} is rendered again from its start: {}", stored.id().value, error.what());
    *checkpoint = {};
    return nullptr;
  }
}

// Writes checkpoints one at a time in the background, so that rendering goes on meanwhile.
class CheckpointWriter {
 public:
  bool busy() const {
    return writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  }
  void Write(std::function<void()> write) {
    Wait();
    writing_ = std::async(std::launch::async, std::move(write));
  }
  void Wait() {
    if (writing_.valid()) writing_.get();
  }
  ~CheckpointWriter() { Wait(); }

 private:
  std::future<void> writing_;
};

}  // namespace

void Farm::Snapshot(Job& job, const Loop& loop) {
  auto image = std::make_shared<const Image>(loop.Develop());
  auto report = DumpJson(ReportToJson(loop.Report()), -1);
  std::lock_guard lock(mutex_);
  job.image = std::move(image);
  job.report = std::move(report);
  job.snapshot_wanted = false;
  changed_.notify_all();
}

void Farm::StoreCheckpoint(Job& job, JobCheckpoint checkpoint) {
  try {
    CrashPoint("checkpoint-begin");
    const Bytes bytes = checkpoint.Serialize();
    const ContentHash blob = blobs_->Put(bytes, BlobStore::For::kCheckpoint);
    CrashPoint("checkpoint-blob");
    ContentHash old;
    Persist(job, [&](StoredJob& stored) {
      old = stored.checkpoint;
      stored.checkpoint = blob;
    });
    CrashPoint("checkpoint-committed");
    if (!old.empty() && old != blob) blobs_->Drop(old);
  } catch (const Error& error) {
    spdlog::warn("{}: no checkpoint ({}); it goes on, and a crash would cost it more", job.stored.id().value,
                 error.what());
    std::lock_guard lock(mutex_);
    job.Log(std::string("no checkpoint: ") + error.what());
  }
}

void Farm::StoreResult(Job& job, const Loop& loop, JobPhase phase, const std::string& error) {
  const Image developed = loop.Develop();
  const ContentHash image = blobs_->Put(Compress(ImageToBytes(developed)), BlobStore::For::kResult);
  const JobReport final_report = FinalReport(loop, developed);
  const std::string report = DumpJson(ReportToJson(final_report), -1);
  ContentHash guide;
  if (Learns(loop.method())) {
    guide = blobs_->Put(
        GuideFile{loop.job(), loop.survey(), final_report.iterations - 1, loop.state()->Serialize(), std::nullopt}
            .Serialize(),
        BlobStore::For::kResult);
  }
  CrashPoint("result-blob");
  PersistEnd(job, [&](StoredJob& stored) {
    stored.image = image;
    stored.guide = guide;
    stored.report = report;
    stored.phase = phase;
    stored.error = error;
  });
  // What was shown while it ran has served its turn.
  std::lock_guard lock(mutex_);
  job.image = nullptr;
  job.report.clear();
}

void Farm::Drive(Job& job) {
  std::string failure;
  std::unique_ptr<Loop> loop;
  try {
    // Step 1: the loop, from where it was.
    JobCheckpoint resumed;
    StoredJob stored;
    {
      std::lock_guard lock(mutex_);
      stored = job.stored;
    }
    const Survey survey = Survey::Parse(stored.survey);
    CheckJob(job.spec, survey);  // again: this start may have less memory than the last
    loop = Restored(*blobs_, stored, &resumed);
    if (!loop) loop = std::make_unique<Loop>(job.spec, survey);
    if (stored.phase != JobPhase::kRunning) Persist(job, [](StoredJob& stored) { stored.phase = JobPhase::kRunning; });
    // Step 2: checkpoints, at the pace of the options; written while workers render, not between rounds.
    CheckpointWriter writer;
    auto last = clock_.Now();
    uint32_t last_iteration = loop->finished() ? 0 : loop->NextRound().iteration;
    const auto checkpoint = [&](const OpenRound* open, bool now) {
      const auto age = clock_.Now() - last;
      const bool advanced = loop->NextRound().iteration != last_iteration;
      if (!now &&
          (writer.busy() || (age < options_.checkpoint_interval && !(advanced && age >= options_.checkpoint_least))))
        return;
      JobCheckpoint position;
      position.loop = loop->Checkpoint();
      if (open) {
        position.round = open->round;
        position.state = open->state_hash;
        std::lock_guard merge(const_cast<OpenRound*>(open)->merge);
        position.nodes = open->reduction.Nodes();
        position.merged = SerializeContribution(open->reduction.merged());
      }
      last_iteration = loop->NextRound().iteration;
      last = clock_.Now();
      writer.Write(
          [this, &job, position = std::move(position)]() mutable { StoreCheckpoint(job, std::move(position)); });
    };
    // Step 3: run.
    bool left = false;  // with the round under way in the last checkpoint
    Loop::Hooks hooks;
    if (!stored.reference.empty()) {
      // Before it is read: an asset may be far larger than any picture of this job.
      if (std::filesystem::file_size(blobs_->PathOf(stored.reference)) !=
          ImageBytesSize(survey.resolution_x, survey.resolution_y))
        throw Error(ErrorKind::kInvalidInput, "the reference has another size than the job's image, " +
                                                  std::to_string(survey.resolution_x) + "x" +
                                                  std::to_string(survey.resolution_y) + " pixels");
      hooks.reference = std::make_shared<const Image>(ImageFromBytes(blobs_->Read(stored.reference)));
    }
    hooks.progress = [&](const JobProgress& progress) {
      bool wanted = false;
      {
        Deferred deferred;
        std::lock_guard lock(mutex_);
        job.progress = progress;
        wanted = job.snapshot_wanted;
        Changed(job, &deferred);
      }
      if (wanted) Snapshot(job, *loop);
    };
    FarmExecutor executor(*this, job, *loop, std::move(resumed), [&](const OpenRound* open) {
      // A snapshot can be answered while a round is under way too: the loop stands at its edge.
      bool wanted = false, ending = false;
      {
        std::lock_guard lock(mutex_);
        wanted = job.snapshot_wanted && job.progress.passes > 0;
        ending = ending_ && !job.cancelled;
      }
      if (wanted) Snapshot(job, *loop);
      checkpoint(open, ending);
      left = ending;
    });
    {
      Deferred deferred;
      std::lock_guard lock(mutex_);
      if (loop->passes() == 0) job.progress = {};  // of a position that could not be restored
      Changed(job, &deferred);
    }
    loop->Run(executor, job.stop, hooks, executor.clock());
    // Step 4: within a round that has to be left, the last checkpoint is the job's position.
    bool leaving = false;
    {
      std::lock_guard lock(mutex_);
      failure = job.failure;
      leaving = ending_ && !job.cancelled && failure.empty();
    }
    if (leaving && !left && !loop->finished()) checkpoint(nullptr, true);
  } catch (const Error& error) {
    failure = error.what();
  } catch (const std::exception& error) {
    failure = std::string("a bug of the coordinator: ") + error.what();
  }
  End(job, loop.get(), failure);
}

// What the job ends as. One that has failed or was cancelled keeps the image of the rounds it has.
void Farm::End(Job& job, const Loop* loop, std::string failure) {
  bool cancelled = false, ending = false;
  {
    std::lock_guard lock(mutex_);
    cancelled = job.cancelled;
    ending = ending_;
    if (!failure.empty() && (job.log.empty() || job.log.back() != failure)) job.Log(failure);
  }
  const bool finished = loop && loop->finished();
  const bool goes_on = failure.empty() && !finished && !cancelled && ending;
  if (failure.empty() && !finished && !cancelled && !ending)
    failure = "its loop ended early, which is a bug of the coordinator";
  const JobPhase phase = !failure.empty() ? JobPhase::kFailed : finished ? JobPhase::kDone : JobPhase::kCancelled;
  if (!goes_on && loop && loop->passes() > 0) {
    if (const std::string choice = loop->Report().choice; !choice.empty()) {
      std::lock_guard lock(mutex_);
      job.Log("chose " + choice);
    }
    try {
      StoreResult(job, *loop, phase, failure);
    } catch (const std::exception& error) {
      // A finished job whose image cannot be stored has failed; one that has failed keeps its first reason.
      spdlog::error("{}: its image was not stored: {}", job.stored.id().value, error.what());
      std::lock_guard lock(mutex_);
      job.Log(std::string("its image was not stored: ") + error.what());
      if (failure.empty()) failure = error.what();
    }
  }
  {
    std::lock_guard lock(mutex_);
    job.driving = false;
  }
  if (!goes_on) EndJob(job, failure.empty() ? phase : JobPhase::kFailed, failure);
}

}  // namespace lodestar
