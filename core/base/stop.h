// A request to end work early, set once from any thread. Work looks at it at least every few milliseconds.
#pragma once

#include <atomic>

namespace lodestar {

class StopToken {
 public:
  void Request() { requested_.store(true, std::memory_order_relaxed); }
  bool Requested() const { return requested_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> requested_{false};
};

}  // namespace lodestar
