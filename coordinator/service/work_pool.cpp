#include "coordinator/service/work_pool.h"

#include <boost/asio/post.hpp>

namespace lodestar {

void WorkPool::Drain() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  threads_.join();
}

bool WorkPool::Post(std::function<void()> task) {
  std::lock_guard lock(mutex_);
  if (ending_ || queued_ >= kMaxQueued) return false;
  ++queued_;
  boost::asio::post(threads_, [this, task = std::move(task)] {
    --queued_;
    task();
  });
  return true;
}

}  // namespace lodestar
