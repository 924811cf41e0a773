// A few threads for what would block gRPC's own: disk, decoding, merging.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace lodestar {

class WorkPool {
 public:
  explicit WorkPool(int threads, size_t max_queued = 4096);
  ~WorkPool() { Drain(); }
  // Finishes what is queued; nothing is taken any more.
  void Drain();
  // False when the queue is full, or drained.
  bool Post(std::function<void()> task);

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> tasks_;
  const size_t max_queued_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace lodestar
