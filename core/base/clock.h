// Time, injectable: tests move a ManualClock by hand and never sleep. Random numbers and plans never see a clock.
#pragma once

#include <atomic>
#include <chrono>

namespace lodestar {

class Clock {
 public:
  using Duration = std::chrono::nanoseconds;
  virtual ~Clock() = default;
  // Monotonic time since an arbitrary start.
  virtual Duration Now() const = 0;
  static const Clock& Steady();
};

class ManualClock final : public Clock {
 public:
  Duration Now() const override { return Duration(now_.load()); }
  void Advance(Duration by) { now_ += by.count(); }

 private:
  std::atomic<int64_t> now_{0};
};

inline double Seconds(Clock::Duration d) {
  return std::chrono::duration<double>(d).count();
}

}  // namespace lodestar
