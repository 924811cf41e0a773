// Retries with exponential, jittered backoff. Time and sleep are injected, so that tests move them by hand.
#pragma once

#include <functional>
#include <random>

#include "core/base/clock.h"
#include "core/base/stop.h"
#include "rpc/status.h"

namespace lodestar {

class Sleeper {
 public:
  virtual ~Sleeper() = default;
  // Early where `stop` (may be null) is requested.
  virtual void Sleep(Clock::Duration duration, const StopToken* stop) = 0;
  static Sleeper& Real();
};

class Backoff {
 public:
  struct Options {
    Clock::Duration first = std::chrono::milliseconds(50), longest = std::chrono::seconds(2);
    double factor = 2;
  };
  explicit Backoff(const Options& options, uint64_t seed = std::random_device()()) : options_(options), random_(seed) {}
  Backoff() : Backoff(Options()) {}
  // Between half and all of the current step, which then grows.
  Clock::Duration Next();
  void Reset() { step_ = {}; }

 private:
  Options options_;
  Clock::Duration step_{};
  std::minstd_rand random_;
};

// A call that is not idempotent may have happened although its answer was lost, so only the caller can say whether to
// repeat it.
enum class Idempotency { kIdempotent, kNotIdempotent };

// Runs `call` until it does not throw UnreachableError, for at most `limit` from the first time that it does (a call
// may itself last longer than that, and be cut at its end) and while `stop` (may be null) is not requested; then the
// last error.
void Retry(Idempotency idempotency, Clock::Duration limit, const Clock& clock, Sleeper& sleeper, Backoff backoff,
           const StopToken* stop, const std::function<void()>& call);

}  // namespace lodestar
