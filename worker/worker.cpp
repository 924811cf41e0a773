#include "worker/worker.h"

#include <unistd.h>

#include <algorithm>

#include "core/base/log.h"
#include "core/base/threads.h"
#include "core/learning/contribution.h"
#include "worker/fingerprint.h"

namespace lodestar {
namespace {

constexpr size_t kPrefetched = 1, kUndelivered = 4;
// What is gathered goes out after this much rendering, whatever comes next: so much is lost with a worker at most.
constexpr double kGatherSeconds = 4;

std::string DefaultName() {
  char host[256] = "host";
  gethostname(host, sizeof host - 1);
  return std::string(host) + ":" + std::to_string(getpid());
}

}  // namespace

Worker::Worker(const Options& options)
    : options_(options),
      info_(DescribeWorker(options.name.empty() ? DefaultName() : options.name,
                           options.threads > 0 ? options.threads : UsableThreads())),
      leasing_(options.coordinator),
      working_(options.coordinator),
      keeping_(options.coordinator),
      assets_(options.cache, options.cache_bytes),
      jobs_(assets_, working_, options.trial) {}

Worker::~Worker() = default;

void Worker::Run() {
  std::thread fetch([this] { FetchLoop(); }), deliver([this] { DeliverLoop(); }), keep([this] { KeepLoop(); });
  RenderLoop();
  fetch.join();
  deliver.join();
  {
    std::lock_guard lock(mutex_);
    delivered_ = true;
  }
  keeping_.Shutdown();
  changed_.notify_all();
  keep.join();
  if (fatal_) std::rethrow_exception(fatal_);
}

void Worker::Drain() {
  {
    std::lock_guard lock(mutex_);
    draining_ = true;
    drain_.Request();
  }
  leasing_.Shutdown();
  changed_.notify_all();
}

void Worker::Fatal(std::exception_ptr error) {
  {
    std::lock_guard lock(mutex_);
    if (!fatal_) fatal_ = error;
  }
  abandon_.Request();
  Drain();
}

void Worker::Persistently(const StopToken* stop, const std::function<void()>& call) {
  Backoff backoff;
  for (int attempt = 0;; ++attempt) {
    try {
      return call();
    } catch (const UnreachableError& error) {
      if ((stop && stop->Requested()) || abandon_.Requested()) throw;
      if (attempt % 20 == 0 && !drain_.Requested()) spdlog::warn("{}; trying again", error.what());
      // At its end a worker waits for a lost coordinator only for as long as its results could still be of use.
      if (drain_.Requested() && attempt > 8) throw;
      Sleeper::Real().Sleep(backoff.Next(), stop);
    }
  }
}

WorkerId Worker::Id() {
  std::lock_guard one(register_);
  {
    std::lock_guard lock(mutex_);
    if (!id_.value.empty()) return id_;
  }
  Registration registration;
  Persistently(&drain_, [&] { registration = working_.Register(info_); });
  spdlog::info("registered at {} as {}", options_.coordinator, registration.id.value);
  std::lock_guard lock(mutex_);
  id_ = registration.id;
  lease_duration_ = registration.lease_duration;
  return id_;
}

void Worker::Forget(const WorkerId& id) {
  std::lock_guard lock(mutex_);
  if (id_ == id) id_ = {};
}

void Worker::Release(LeaseId lease) {
  std::lock_guard lock(mutex_);
  held_.erase(lease);
}

// ---- leases in ----

void Worker::FetchLoop() {
  Backoff backoff;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return draining_ || ready_.size() < kPrefetched; });
      if (draining_) break;
    }
    WorkerId id;
    try {
      id = Id();
      auto unit = leasing_.Lease(id, std::chrono::seconds(20));
      backoff.Reset();
      if (!unit) continue;
      Held held{std::move(*unit)};
      {
        std::lock_guard lock(mutex_);
        held_.emplace(held.unit.id, held.stop);
      }
      // The state of the next iteration is fetched and parsed while the last units of this one render.
      if (held.unit.render) {
        if (auto job = jobs_.Find(held.unit.description)) {
          try {
            (void)job->StateFor(held.unit.render->state, working_);
          } catch (const Error&) {
            // The renderer meets the same, and deals with it.
          }
        }
      }
      {
        std::lock_guard lock(mutex_);
        ready_.push_back(std::move(held));
      }
      changed_.notify_all();
    } catch (const UnreachableError& error) {
      if (drain_.Requested()) break;
      Sleeper::Real().Sleep(backoff.Next(), &drain_);
    } catch (const ProtocolError&) {
      Fatal(std::current_exception());
      break;
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kNotFound) {
        Forget(id);
      } else {
        spdlog::warn("asking for work: {}", error.what());
        Sleeper::Real().Sleep(backoff.Next(), &drain_);
      }
    }
  }
  {
    std::lock_guard lock(mutex_);
    fetched_ = true;
  }
  changed_.notify_all();
}

void Worker::KeepLoop() {
  Backoff backoff;
  while (true) {
    WorkerId id;
    std::vector<LeaseId> leases;
    Clock::Duration wait;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return delivered_ || !id_.value.empty() || fetched_; });
      if (delivered_) return;
      if (id_.value.empty()) {
        changed_.wait_for(lock, std::chrono::milliseconds(50));
        continue;
      }
      id = id_;
      wait = lease_duration_ / 4;
      for (const auto& [lease, stop] : held_) leases.push_back(lease);
    }
    try {
      const auto revoked = keeping_.RenewLease(id, leases, wait);
      backoff.Reset();
      std::lock_guard lock(mutex_);
      for (const auto lease : revoked) {
        if (const auto it = held_.find(lease); it != held_.end()) it->second->Request();
      }
    } catch (const UnreachableError&) {
      StopToken none;
      Sleeper::Real().Sleep(backoff.Next(), &none);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kNotFound) {
        Forget(id);
      } else {
        Sleeper::Real().Sleep(backoff.Next(), nullptr);
      }
    }
  }
}

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
        held.unit.render ? Render(held) : Survey(held);
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
  spdlog::info("rendered {} leases in {:.2f} s, waited {:.2f} s between them", leases_, rendering_seconds_, waited);
  {
    std::lock_guard lock(mutex_);
    rendered_ = true;
  }
  changed_.notify_all();
}

void Worker::Fail(const Held& held, UnitFailure::Kind kind, const std::string& message) {
  if (!message.empty())
    spdlog::warn("{} of {}: {}", held.unit.render ? held.unit.render->node.ToString() : "survey", held.unit.job.value,
                 message);
  Release(held.unit.id);
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
    complete = gathered_->job->Execute(unit, gathered_->state, static_cast<int>(info_.threads), *held.stop,
                                       &gathered_->contribution);
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
