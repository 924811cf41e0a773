// What is computed once and kept, by many threads at once: entries of `blocks` times `slots`, each a pure function of
// its place, so it does not show who made it, or whether it was kept. The number kept is limited.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace lodestar {

template <class T, uint32_t kSlots>
class GridMemo {
 public:
  GridMemo(uint32_t blocks, uint32_t most) : blocks_(blocks), left_(most) {}
  GridMemo(const GridMemo&) = delete;
  GridMemo& operator=(const GridMemo&) = delete;
  ~GridMemo() {
    for (std::atomic<Block*>& block : blocks_) {
      if (Block* b = block.load(std::memory_order_relaxed)) {
        for (std::atomic<const T*>& slot : *b) delete slot.load(std::memory_order_relaxed);
        delete b;
      }
    }
  }

  // The entry, from make() where it is not kept yet. Where no more are kept, `own` holds it.
  template <class Make>
  const T* Get(uint32_t block, uint32_t slot, std::unique_ptr<const T>* own, Make&& make) const {
    Block* b = blocks_[block].load(std::memory_order_acquire);
    if (b == nullptr) {
      auto made = std::make_unique<Block>();
      if (blocks_[block].compare_exchange_strong(b, made.get(), std::memory_order_acq_rel)) b = made.release();
    }
    std::atomic<const T*>& at = (*b)[slot];
    if (const T* kept = at.load(std::memory_order_acquire)) return kept;
    auto made = std::make_unique<const T>(make());
    if (left_.fetch_sub(1, std::memory_order_relaxed) <= 0) {
      left_.fetch_add(1, std::memory_order_relaxed);
      *own = std::move(made);
      return own->get();
    }
    const T* kept = nullptr;
    if (at.compare_exchange_strong(kept, made.get(), std::memory_order_acq_rel)) return made.release();
    left_.fetch_add(1, std::memory_order_relaxed);
    return kept;
  }

 private:
  using Block = std::array<std::atomic<const T*>, kSlots>;
  mutable std::vector<std::atomic<Block*>> blocks_;
  mutable std::atomic<int64_t> left_;
};

}  // namespace lodestar
