// A few threads for what would block gRPC's own: disk, decoding, merging.
#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <mutex>

namespace lodestar {

class WorkPool {
 public:
  explicit WorkPool(int threads) : threads_(static_cast<size_t>(threads)) {}
  ~WorkPool() { Drain(); }
  // Finishes what is queued; nothing is taken any more.
  void Drain();
  // False when the queue is full, or drained.
  bool Post(std::function<void()> task);

 private:
  static constexpr size_t kMaxQueued = 4096;
  std::atomic<size_t> queued_ = 0;
  std::mutex mutex_;  // nothing is posted once the threads are joined
  bool ending_ = false;
  boost::asio::thread_pool threads_;
};

}  // namespace lodestar
