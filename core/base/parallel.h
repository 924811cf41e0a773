// A loop whose passes are independent, on the threads of oneTBB. Its users link TBB::tbb.
//
// ThreadSanitizer does not see how TBB, which is not instrumented, hands work over, and reports all of it. To suppress
// what has a frame of TBB's would hide the races of every loop's body too, so that build has plain threads here.
#pragma once

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

#include "core/base/threads.h"
#endif

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

namespace lodestar {

// Runs body(0) to body(count - 1) and waits for them; what one throws passes through. `Partitioner` is TBB's:
// simple_partitioner where each pass is to be a task of its own.
template <class Partitioner = tbb::auto_partitioner, class Body>
void ParallelFor(uint32_t count, const Body& body) {
#ifdef __SANITIZE_THREAD__
  std::vector<std::exception_ptr> failures(std::min(count, static_cast<uint32_t>(std::max(2, UsableThreads()))));
  std::atomic<uint32_t> next{0};
  {
    std::vector<std::jthread> threads;
    for (std::exception_ptr& failure : failures) {
      threads.emplace_back([&] {
        try {
          for (uint32_t i; (i = next.fetch_add(1)) < count;) body(i);
        } catch (...) {
          failure = std::current_exception();
        }
      });
    }
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
#else
  tbb::parallel_for(uint32_t{0}, count, body, Partitioner());
#endif
}

}  // namespace lodestar
