#include "core/guiding/zero_pages.h"

#include <sys/mman.h>

#include "core/base/check.h"
#include "core/base/error.h"

namespace lodestar {

void* MapZeroPages(size_t bytes) {
  void* const address =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) {
    throw Error(ErrorKind::kIo, "cannot map " + std::to_string(bytes) +
                                    " bytes for tree statistics; lower the SD-tree's max_nodes or the thread count");
  }
  madvise(address, bytes, MADV_HUGEPAGE);  // advice: refused, it costs only speed
  return address;
}

void UnmapPages(void* address, size_t bytes) {
  LODESTAR_CHECK(munmap(address, bytes) == 0);
}

}  // namespace lodestar
