// Runs while somebody works: the time that a job's budget counts. Those who work say so; several may at once.
// Thread-safe.
#pragma once

#include <mutex>

#include "core/base/check.h"
#include "core/base/clock.h"

namespace lodestar {

class BusyClock final : public Clock {
 public:
  // Nobody works yet. `clock` lives longer.
  explicit BusyClock(const Clock& clock) : clock_(clock) {}
  Duration Now() const override {
    std::lock_guard lock(mutex_);
    return passed_ + (workers_ > 0 ? clock_.Now() - since_ : Duration{});
  }
  void Begin() {
    std::lock_guard lock(mutex_);
    if (workers_++ == 0) since_ = clock_.Now();
  }
  void End() {
    std::lock_guard lock(mutex_);
    LODESTAR_CHECK(workers_ > 0);
    if (--workers_ == 0) passed_ += clock_.Now() - since_;
  }

 private:
  const Clock& clock_;
  mutable std::mutex mutex_;
  int workers_ = 0;
  Duration since_{}, passed_{};  // when it began to run, and what had passed before
};

}  // namespace lodestar
