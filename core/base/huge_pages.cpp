#include "core/base/huge_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace lodestar {

void* MapLargePages(size_t bytes, Commit commit) {
  const size_t roomy = bytes + kLargePage;
  void* const mapped = mmap(nullptr, roomy, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | (commit == Commit::kLater ? MAP_NORESERVE : 0), -1, 0);
  if (mapped == MAP_FAILED) return nullptr;
  char* const begin = static_cast<char*>(mapped);
  const size_t before = (kLargePage - reinterpret_cast<uintptr_t>(begin) % kLargePage) % kLargePage;
  if (before > 0) munmap(begin, before);
  munmap(begin + before + bytes, kLargePage - before);
  madvise(begin + before, bytes, MADV_HUGEPAGE);  // advice: refused, it costs only speed
  return begin + before;
}

void UnmapLargePages(void* address, size_t bytes) {
  munmap(address, bytes);
}

}  // namespace lodestar
