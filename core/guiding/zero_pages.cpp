#include "core/guiding/zero_pages.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/huge_pages.h"

namespace lodestar {
namespace {

// Arrays below a large page come from the heap and are not worth keeping. Larger ones get address space to grow in,
// which costs nothing, so that the pages of one state's sums serve the next state's, which has more.
constexpr size_t kRoom = 8;
constexpr size_t kMostKept = 8, kMostKeptBytes = size_t{512} << 20;

std::mutex mutex;
std::vector<ZeroMapping> kept;  // guarded by `mutex`

constexpr size_t RoundUp(size_t bytes, size_t to) {
  return (bytes + to - 1) / to * to;
}

}  // namespace

ZeroMapping MapZeroPages(size_t bytes) {
  void* address = nullptr;
  if (bytes < kLargePage) {
    constexpr size_t kLine = 64;
    bytes = RoundUp(bytes, kLine);
    address = std::aligned_alloc(kLine, bytes);
    if (address != nullptr) std::memset(address, 0, bytes);
  } else {
    {
      std::lock_guard lock(mutex);
      // The one with most pages among those that fit and are not far too large.
      auto best = kept.end();
      for (auto it = kept.begin(); it != kept.end(); ++it) {
        if (it->bytes >= bytes && it->backed / kRoom <= bytes && (best == kept.end() || it->backed > best->backed))
          best = it;
      }
      if (best != kept.end()) {
        const ZeroMapping mapping = *best;
        kept.erase(best);
        return mapping;
      }
    }
    const size_t roomy = std::bit_ceil(bytes) * kRoom;
    address = MapLargePages(roomy, Commit::kLater);
    if (address != nullptr) return {address, roomy, 0};
    bytes = RoundUp(bytes, kLargePage);
    address = MapLargePages(bytes, Commit::kLater);
  }
  if (address == nullptr) {
    throw Error(ErrorKind::kIo, "cannot map " + std::to_string(bytes) +
                                    " bytes for tree statistics; lower the SD-tree's max_nodes or the thread count");
  }
  return {address, bytes, 0};
}

void Unmap(ZeroMapping mapping) {
  if (mapping.bytes < kLargePage) {
    std::free(mapping.address);
  } else {
    UnmapLargePages(mapping.address, mapping.bytes);
  }
}

void KeepZeroPages(ZeroMapping mapping, size_t used) {
  LODESTAR_DCHECK(std::all_of(static_cast<const char*>(mapping.address),
                              static_cast<const char*>(mapping.address) + used, [](char byte) { return byte == 0; }));
  mapping.backed = std::max(mapping.backed, used);
  if (mapping.backed >= kLargePage) {
    std::lock_guard lock(mutex);
    size_t total = mapping.backed;
    for (const ZeroMapping& other : kept) total += other.backed;
    if (kept.size() < kMostKept && total <= kMostKeptBytes) {
      kept.push_back(mapping);
      return;
    }
  }
  Unmap(mapping);
}

}  // namespace lodestar
