// What a worker does with its leases: renders, gathers, delivers, and says what it could not do.
#include <tbb/task_arena.h>

#include <utility>

#include "core/base/log.h"
#include "core/guiding/tree_request.h"
#include "core/learning/contribution.h"
#include "worker/worker.h"

namespace lodestar {
namespace {

constexpr size_t kUndelivered = 4;
// What is gathered goes out after this much rendering, whatever comes next: so much is lost with a worker at most.
constexpr double kGatherSeconds = 4;

}  // namespace

// ---- rendering ----

void Worker::RenderLoop() {
  double waited = 0;
  while (true) {
    Held held;
    bool give_back = false;
    {
      std::unique_lock lock(mutex_);
      // Nothing to go on with, or nothing that can be added: others wait for what is gathered.
      if (gathered_ && (ready_.empty() || !gathered_->header.Takes(ready_.front().unit) ||
                        gathered_->header.seconds > kGatherSeconds)) {
        lock.unlock();
        Deliver();
        lock.lock();
      }
      const auto start = Clock::Steady().Now();
      changed_.wait(lock, [&] { return !ready_.empty() || fetched_; });
      if (ready_.empty()) break;
      // Between two units of one state a worker should hardly ever wait; the first wait of all is for a job to come.
      if (leases_ > 0) waited += Seconds(Clock::Steady().Now() - start);
      held = std::move(ready_.front());
      ready_.pop_front();
      give_back = draining_;
    }
    changed_.notify_all();
    try {
      if (held.stop->Requested()) {
        Release(held.unit.id);
      } else if (give_back) {
        Fail(held, UnitFailure::Kind::kReturned, "");
      } else {
        held.unit.render ? Render(held) : held.unit.shard ? MakeTrees(held) : Survey(held);
      }
    } catch (const UnreachableError&) {
      Release(held.unit.id);
    } catch (const std::exception& error) {
      if (held.stop->Requested()) {
        Release(held.unit.id);
        continue;
      }
      try {
        Fail(held, UnitFailure::Kind::kWorker, error.what());
      } catch (const Error&) {
        Release(held.unit.id);
      }
    }
  }
  Deliver();
  spdlog::info("rendered {} leases in {:.2f} s, waited {:.2f} s between them; made {} shards of trees", leases_,
               rendering_seconds_, waited, shards_);
  {
    std::lock_guard lock(mutex_);
    rendered_ = true;
  }
  changed_.notify_all();
}

void Worker::Fail(const Held& held, UnitFailure::Kind kind, const std::string& message) {
  if (!message.empty())
    spdlog::warn("{} of {}: {}",
                 held.unit.render  ? held.unit.render->node.ToString()
                 : held.unit.shard ? "shard"
                                   : "survey",
                 held.unit.job.value, message);
  Release(held.unit.id);
  // What ends a worker may have ended its child too, and cuts its patience short: nobody's fault.
  if (drain_.Requested()) kind = UnitFailure::Kind::kReturned;
  Persistently(held.stop.get(), [&] {
    try {
      working_.ReportFailure({kind, Id(), held.unit.id, held.unit.job, message});
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kNotFound)
        throw;  // the coordinator knows neither worker nor lease: nothing to give back
    }
  });
}

void Worker::Survey(const Held& held) {
  SurveyResult result;
  result.lease = held.unit.id;
  result.job = held.unit.job;
  Persistently(held.stop.get(), [&] {
    try {
      result.survey = jobs_.Load(held.unit.description, *held.stop)->survey().Serialize();
    } catch (const UnreachableError&) {
      throw;
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kIo) throw;
      result.scene_error = error.what();
    }
  });
  Persistently(held.stop.get(), [&] {
    const WorkerId id = Id();
    try {
      result.worker = id;
      working_.SubmitSurvey(result);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kNotFound) throw;
      Forget(id);  // the coordinator has restarted; it will ask again
    }
  });
  Release(held.unit.id);
}

// What goes wrong here is nobody's fault and need not be told: what has not come the coordinator makes itself.
void Worker::MakeTrees(const Held& held) {
  const auto job = jobs_.Find(held.unit.description);
  tbb::task_arena arena(job ? job->threads() : static_cast<int>(info_.threads));
  ++shards_;
  try {
    ShardAnswer answer{Id(), held.unit.id, held.unit.job, {}};
    arena.execute([&] { answer.trees = AnswerTreeRequest(held.unit.shard->request, *held.stop); });
    if (!answer.trees.empty() && answer.trees.size() <= kMaxShardBytes) working_.SubmitShard(answer);
  } catch (const std::exception& error) {
    spdlog::warn("a shard of trees of {} is left to the coordinator: {}", held.unit.job.value, error.what());
  }
  Release(held.unit.id);
}

void Worker::Render(const Held& held) {
  const RenderUnit& unit = *held.unit.render;
  if (!gathered_) {
    Gathered begun;
    try {
      Persistently(held.stop.get(), [&] {
        begun.job = jobs_.Load(held.unit.description, *held.stop);
        begun.state = begun.job->StateFor(unit.state, working_);
      });
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kNotFound || dynamic_cast<const UnreachableError*>(&error)) throw;
      return Fail(held, UnitFailure::Kind::kReturned, "");  // that state is over
    }
    gathered_ = std::move(begun);
  }
  const auto start = Clock::Steady().Now();
  bool complete = false;
  try {
    complete = gathered_->job->Execute(unit, gathered_->state, *held.stop, &gathered_->contribution);
  } catch (...) {
    GiveBack(std::exchange(gathered_, std::nullopt)->leases);
    throw;
  }
  if (!complete) {
    GiveBack(std::exchange(gathered_, std::nullopt)->leases);
    return Release(held.unit.id);
  }
  const double seconds = Seconds(Clock::Steady().Now() - start);
  gathered_->header.Add(held.unit);
  gathered_->header.seconds += seconds;
  gathered_->leases.push_back(held);
  rendering_seconds_ += seconds;
  ++leases_;
}

void Worker::Deliver() {
  if (!gathered_) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return deliveries_.size() < kUndelivered || abandon_.Requested(); });
  deliveries_.push_back(*std::exchange(gathered_, std::nullopt));
  lock.unlock();
  changed_.notify_all();
}

void Worker::GiveBack(const std::vector<Held>& leases, UnitFailure::Kind kind, std::string why) {
  for (const Held& held : leases) Release(held.unit.id);
  for (const Held& held : leases) {
    Fail(held, kind, why);
    // What has one cause is one failure, however many leases it costs.
    kind = UnitFailure::Kind::kReturned;
    why.clear();
  }
}

// ---- results out ----

void Worker::Send(Gathered& delivery, const std::string& what) {
  const auto start = Clock::Steady().Now();
  const Bytes bytes = SerializeContribution(delivery.contribution);
  ++deliveries_made_;
  delivered_bytes_ += bytes.size();
  delivery.contribution = {};  // its memory serves the next
  Persistently(nullptr, [&] {
    // Whoever this worker is by now: results are taken from anyone.
    delivery.header.worker = Id();
    const auto outcome = working_.SubmitContribution(delivery.header, bytes);
    spdlog::debug("{}: outcome {}", what, static_cast<int>(outcome));
  });
  delivering_seconds_ += Seconds(Clock::Steady().Now() - start);
}

void Worker::DeliverLoop() {
  while (true) {
    Gathered delivery;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return !deliveries_.empty() || rendered_; });
      if (deliveries_.empty()) break;
      delivery = std::move(deliveries_.front());
      deliveries_.pop_front();
    }
    changed_.notify_all();
    const ContributionHeader& header = delivery.header;
    const std::string what = std::to_string(header.nodes.size()) + " leases of iteration " +
                             std::to_string(header.round.iteration) + ", round " + std::to_string(header.round.index) +
                             " of " + header.job.value;
    try {
      try {
        Send(delivery, what);
      } catch (const UnreachableError&) {
        throw;
      } catch (const std::exception& error) {
        // Dropped without a word, these units would be leased and refused again, for ever.
        GiveBack(delivery.leases, UnitFailure::Kind::kWorker, what + " could not be delivered: " + error.what());
      }
    } catch (const Error& error) {
      spdlog::warn("{} were not delivered: {}", what, error.what());
    }
    for (const Held& held : delivery.leases) Release(held.unit.id);
  }
  spdlog::info("delivered {} times, {:.1f} MiB in {:.2f} s, beside rendering", deliveries_made_,
               static_cast<double>(delivered_bytes_) / (1 << 20), delivering_seconds_);
}

}  // namespace lodestar
