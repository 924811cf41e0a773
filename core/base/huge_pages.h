// Memory for large arrays that are read at random, texels and vertices: on pages of 2 MiB where the system grants them,
// so that a read misses the cache but not the translation of its address too, and aligned to cache lines in any case.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace lodestar {

inline constexpr size_t kLargePage = size_t{2} << 20;
enum class Commit { kNow, kLater };
// Zeroes, aligned to kLargePage; null where there is no more memory. `bytes` is a multiple of kLargePage. kLater: of
// address space that will be touched in parts, which the system need not have memory for.
void* MapLargePages(size_t bytes, Commit commit);
void UnmapLargePages(void* address, size_t bytes);

template <class T>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  // Large arrays get a mapping of their own: memory that the heap has handed out before is on small pages, and stays
  // so.
  T* allocate(size_t count) {
    const size_t bytes = count * sizeof(T);
    void* const memory = bytes < kLargePage ? std::aligned_alloc(kLine, RoundUp(bytes, kLine))
                                            : MapLargePages(RoundUp(bytes, kLargePage), Commit::kNow);
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t count) {
    const size_t bytes = count * sizeof(T);
    if (bytes < kLargePage) {
      std::free(memory);
    } else {
      UnmapLargePages(memory, RoundUp(bytes, kLargePage));
    }
  }
  friend bool operator==(HugePageAllocator, HugePageAllocator) { return true; }

 private:
  static constexpr size_t kLine = 64;
  static constexpr size_t RoundUp(size_t bytes, size_t to) { return (bytes + to - 1) / to * to; }
};

template <class T>
using LargeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace lodestar
