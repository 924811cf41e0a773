// An array of zeroes straight from the operating system: pages that are never touched cost nothing, so an accumulator
// as wide as the state is cheap to create for a second's work. Large pages are of 2 MiB where the system grants them,
// so that an addition at random misses the cache but not the translation of its address too.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

namespace lodestar {

// Throws Error(kIo) when the address space is refused.
void* MapZeroPages(size_t bytes);
void UnmapPages(void* address, size_t bytes);

// T must be valid when all its bytes are zero.
template <class T>
requires std::is_trivially_copyable_v<T>
class ZeroPages {
 public:
  ZeroPages() = default;
  explicit ZeroPages(size_t size)
      : data_(size > 0 ? static_cast<T*>(MapZeroPages(size * sizeof(T))) : nullptr), size_(size) {}
  ZeroPages(ZeroPages&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  ZeroPages& operator=(ZeroPages&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~ZeroPages() {
    if (data_ != nullptr) UnmapPages(data_, size_ * sizeof(T));
  }
  T& operator[](size_t i) { return data_[i]; }
  const T& operator[](size_t i) const { return data_[i]; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  size_t size() const { return size_; }

 private:
  T* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace lodestar
