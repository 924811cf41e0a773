// Memory for large arrays that are read at random, texels and vertices: on pages of 2 MiB where the system grants them,
// so that a read misses the cache but not the translation of its address too, and aligned to cache lines in any case.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace lodestar {

template <class T>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(size_t count) {
    static constexpr size_t kLine = 64, kPage = size_t{2} << 20;
    const size_t bytes = count * sizeof(T), alignment = bytes >= kPage ? kPage : kLine;
    void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (!memory) throw std::bad_alloc();
    if (alignment == kPage) madvise(memory, bytes, MADV_HUGEPAGE);  // advice: refused, it costs only speed
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t) { std::free(memory); }
  friend bool operator==(HugePageAllocator, HugePageAllocator) { return true; }
};

template <class T>
using LargeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace lodestar
