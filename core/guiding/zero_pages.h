// An array of zeroes, from 2 MiB on straight from the operating system: pages that are never touched cost nothing, so
// an accumulator as wide as the state is cheap to create for a second's work. Large pages are of 2 MiB where the system
// grants them, so that an addition at random misses the cache but not the translation of its address too.
//
// Pages that were touched are dear: the system clears each before it hands it out (measured in a virtual machine: 1 ms
// a MiB). So whoever has cleared what it touched may keep the pages for the process's next array.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

namespace lodestar {

struct ZeroMapping {
  void* address = nullptr;
  size_t bytes = 0;   // of address space
  size_t backed = 0;  // of those, from the start: may have pages from an earlier use
};
// Of at least so many bytes, aligned to a cache line. Throws Error(kIo) when the address space is refused.
ZeroMapping MapZeroPages(size_t bytes);
void Unmap(ZeroMapping mapping);
// For a later MapZeroPages; unmapped where enough is kept. All bytes must be zero; `used`: how many may have got pages
// since.
void KeepZeroPages(ZeroMapping mapping, size_t used);

// T must be valid when all its bytes are zero.
template <class T>
requires std::is_trivially_copyable_v<T>
class ZeroPages {
 public:
  ZeroPages() = default;
  explicit ZeroPages(size_t size) : mapping_(size > 0 ? MapZeroPages(size * sizeof(T)) : ZeroMapping()), size_(size) {}
  ZeroPages(ZeroPages&& other) noexcept
      : mapping_(std::exchange(other.mapping_, {})), size_(std::exchange(other.size_, 0)) {}
  ZeroPages& operator=(ZeroPages&& other) noexcept {
    std::swap(mapping_, other.mapping_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~ZeroPages() {
    if (mapping_.address != nullptr) Unmap(mapping_);
  }
  // Leaves it empty. All elements must be zero again.
  void Keep() {
    if (mapping_.address != nullptr) KeepZeroPages(std::exchange(mapping_, {}), std::exchange(size_, 0) * sizeof(T));
  }
  T& operator[](size_t i) { return data()[i]; }
  const T& operator[](size_t i) const { return data()[i]; }
  T* data() { return static_cast<T*>(mapping_.address); }
  const T* data() const { return static_cast<const T*>(mapping_.address); }
  size_t size() const { return size_; }

 private:
  ZeroMapping mapping_;
  size_t size_ = 0;
};

}  // namespace lodestar
