#include "core/guiding/zero_pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

// Smaller arrays are not worth keeping. Larger ones get address space to grow in, which costs nothing, so that the
// pages of one state's sums serve the next state's, which has more.
constexpr size_t kSmall = size_t{1} << 20, kRoom = 8;
constexpr size_t kMostKept = 8, kMostKeptBytes = size_t{512} << 20;

struct Kept {
  ZeroMapping mapping;
  size_t used;
};
std::mutex mutex;
std::vector<Kept> kept;  // guarded by `mutex`

void* Map(size_t bytes) {
  void* const address =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) return nullptr;
  madvise(address, bytes, MADV_HUGEPAGE);  // advice: refused, it costs only speed
  return address;
}

}  // namespace

ZeroMapping MapZeroPages(size_t bytes) {
  if (bytes >= kSmall) {
    {
      std::lock_guard lock(mutex);
      // The one with most pages among those that fit and are not far too large.
      auto best = kept.end();
      for (auto it = kept.begin(); it != kept.end(); ++it) {
        if (it->mapping.bytes >= bytes && it->used / kRoom <= bytes && (best == kept.end() || it->used > best->used))
          best = it;
      }
      if (best != kept.end()) {
        const ZeroMapping mapping = best->mapping;
        kept.erase(best);
        return mapping;
      }
    }
    const size_t roomy = std::bit_ceil(bytes) * kRoom;
    if (void* const address = Map(roomy)) return {address, roomy};
  }
  void* const address = Map(bytes);
  if (address == nullptr) {
    throw Error(ErrorKind::kIo, "cannot map " + std::to_string(bytes) +
                                    " bytes for tree statistics; lower the SD-tree's max_nodes or the thread count");
  }
  return {address, bytes};
}

void Unmap(ZeroMapping mapping) {
  LODESTAR_CHECK(munmap(mapping.address, mapping.bytes) == 0);
}

void KeepZeroPages(ZeroMapping mapping, size_t used) {
  LODESTAR_DCHECK(std::all_of(static_cast<const char*>(mapping.address),
                              static_cast<const char*>(mapping.address) + used, [](char byte) { return byte == 0; }));
  if (used >= kSmall) {
    std::lock_guard lock(mutex);
    size_t total = used;
    for (const Kept& other : kept) total += other.used;
    if (kept.size() < kMostKept && total <= kMostKeptBytes) {
      kept.push_back({mapping, used});
      return;
    }
  }
  Unmap(mapping);
}

}  // namespace lodestar
