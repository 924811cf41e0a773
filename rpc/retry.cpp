#include "rpc/retry.h"

#include <algorithm>
#include <optional>
#include <thread>

namespace lodestar {
namespace {

class RealSleeper final : public Sleeper {
 public:
  void Sleep(Clock::Duration duration, const StopToken* stop) override {
    const auto end = std::chrono::steady_clock::now() + duration;
    while (std::chrono::steady_clock::now() < end && !(stop && stop->Requested())) {
      std::this_thread::sleep_for(
          std::min<Clock::Duration>(std::chrono::milliseconds(50), end - std::chrono::steady_clock::now()));
    }
  }
};

}  // namespace

Sleeper& Sleeper::Real() {
  static RealSleeper sleeper;
  return sleeper;
}

Clock::Duration Backoff::Next() {
  step_ = step_.count() == 0
              ? options_.first
              : std::min(options_.longest,
                         Clock::Duration(static_cast<int64_t>(static_cast<double>(step_.count()) * options_.factor)));
  return Clock::Duration(std::uniform_int_distribution<int64_t>(step_.count() / 2, step_.count())(random_));
}

void Retry(Idempotency idempotency, Clock::Duration limit, const Clock& clock, Sleeper& sleeper, Backoff backoff,
           const StopToken* stop, const std::function<void()>& call) {
  std::optional<Clock::Duration> end;
  while (true) {
    try {
      return call();
    } catch (const UnreachableError&) {
      const auto pause = backoff.Next();
      if (!end) end = clock.Now() + limit;
      if (idempotency == Idempotency::kNotIdempotent || clock.Now() + pause > *end || (stop && stop->Requested()))
        throw;
      sleeper.Sleep(pause, stop);
    }
  }
}

}  // namespace lodestar
