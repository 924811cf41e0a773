#include "worker/worker.h"

#include <unistd.h>

#include <thread>

#include "core/base/log.h"
#include "core/base/threads.h"
#include "worker/fingerprint.h"

namespace lodestar {
namespace {

constexpr size_t kPrefetched = 1;

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
      jobs_(assets_, working_, options.trial, static_cast<int>(info_.threads)) {}

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
  // Half a minute. What is still refused then is refused for itself and not for what else is at hand there.
  constexpr int kMostWhenExhausted = 20;
  Backoff backoff;
  for (int attempt = 0;; ++attempt) {
    try {
      return call();
    } catch (const ExhaustedError& error) {
      if (attempt >= kMostWhenExhausted || (stop && stop->Requested()) || abandon_.Requested() || drain_.Requested())
        throw;
      Sleeper::Real().Sleep(backoff.Next(), stop);
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
      // Those that are void would be answered at once, and again, until the renderer has put them down.
      for (const auto& [lease, stop] : held_)
        if (!stop->Requested()) leases.push_back(lease);
    }
    try {
      const auto revoked = keeping_.RenewLease(id, leases, wait);
      backoff.Reset();
      std::lock_guard lock(mutex_);
      for (const auto lease : revoked) {
        if (const auto it = held_.find(lease); it != held_.end()) it->second->Request();
      }
    } catch (const UnreachableError&) {
      Sleeper::Real().Sleep(backoff.Next(), nullptr);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kNotFound) {
        Forget(id);
      } else {
        Sleeper::Real().Sleep(backoff.Next(), nullptr);
      }
    }
  }
}

}  // namespace lodestar
