// Memory for large arrays that are read at random, texels and vertices: on pages of 2 MiB where the system grants them,
// so that a read misses the cache but not the translation of its address too, and aligned to cache lines in any case.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
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

  // Large arrays get a mapping of their own: memory that the heap has handed out before is on small pages, and stays
  // so.
  T* allocate(size_t count) {
    const size_t bytes = count * sizeof(T);
    void* const memory =
        bytes < kPage ? std::aligned_alloc(kLine, RoundUp(bytes, kLine)) : MapPages(RoundUp(bytes, kPage));
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t count) {
    const size_t bytes = count * sizeof(T);
    if (bytes < kPage) {
      std::free(memory);
    } else {
      munmap(memory, RoundUp(bytes, kPage));
    }
  }
  friend bool operator==(HugePageAllocator, HugePageAllocator) { return true; }

 private:
  static constexpr size_t kLine = 64, kPage = size_t{2} << 20;
  static constexpr size_t RoundUp(size_t bytes, size_t to) { return (bytes + to - 1) / to * to; }
  // Null where there is no more memory. `bytes` is a multiple of kPage.
  static void* MapPages(size_t bytes) {
    void* const mapped = mmap(nullptr, bytes + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) return nullptr;
    char* const begin = static_cast<char*>(mapped);
    const size_t before = (kPage - reinterpret_cast<uintptr_t>(begin) % kPage) % kPage;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, kPage - before);
    madvise(begin + before, bytes, MADV_HUGEPAGE);  // advice: refused, it costs only speed
    return begin + before;
  }
};

template <class T>
using LargeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace lodestar
