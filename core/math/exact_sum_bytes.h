// Exact sums as bytes. Whole numbers take 7 bits a byte, sums their significant bytes behind one byte that says which.
// Every value has one form only; readers fail (Error kCorrupt) for any other.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/base/bytes.h"
#include "core/math/exact_sum.h"

namespace lodestar {

// Into memory with room for kVarintRoom and kWideRoom bytes, of which more may be written to than are used; they return
// the end. For writers of millions.
inline constexpr size_t kVarintRoom = 10, kWideRoom = 17;
inline char* WriteVarint(char* at, uint64_t value) {
  for (; value >= 0x80; value >>= 7) *at++ = static_cast<char>(value | 0x80);
  *at++ = static_cast<char>(value);
  return at;
}
// Zigzag, then the bytes between the lowest and highest that are not zero. Header: skipped low bytes * 16 + count - 1;
// 0xff for zero.
inline char* WriteWide(char* at, __int128 value) {
  const unsigned __int128 bits =
      (static_cast<unsigned __int128>(value) << 1) ^ static_cast<unsigned __int128>(value >> 127);
  const auto low = static_cast<uint64_t>(bits), high = static_cast<uint64_t>(bits >> 64);
  if (high == 0 && low != 0) [[likely]] {
    const int skipped = std::countr_zero(low) / 8, last = (63 - std::countl_zero(low)) / 8;
    const uint64_t shifted = low >> (8 * skipped);
    *at = static_cast<char>(skipped * 16 + last - skipped);
    std::memcpy(at + 1, &shifted, 8);  // little-endian, as everything written here
    return at + (last - skipped + 2);
  }
  if (bits == 0) {
    *at = static_cast<char>(0xff);
    return at + 1;
  }
  const int skipped = (low != 0 ? std::countr_zero(low) : 64 + std::countr_zero(high)) / 8,
            last = (127 - std::countl_zero(high)) / 8;
  const unsigned __int128 shifted = bits >> (8 * skipped);
  *at = static_cast<char>(skipped * 16 + last - skipped);
  std::memcpy(at + 1, &shifted, 16);
  return at + (last - skipped + 2);
}

inline void PutVarint(ByteWriter& out, uint64_t value) {
  char bytes[kVarintRoom];
  out.PutRaw({bytes, WriteVarint(bytes, value)});
}
inline void PutWide(ByteWriter& out, __int128 value) {
  char bytes[kWideRoom];
  out.PutRaw({bytes, WriteWide(bytes, value)});
}

uint64_t GetLongVarint(ByteReader& in, uint64_t first);
inline uint64_t GetVarint(ByteReader& in) {
  const uint64_t first = in.Get<uint8_t>();
  return first < 0x80 ? first : GetLongVarint(in, first);
}
__int128 GetWide(ByteReader& in);

// A sum of addends that are not negative.
inline void PutSum(ByteWriter& out, const ExactSum& sum) {
  PutWide(out, sum.Units());
}
ExactSum GetAnySum(ByteReader& in);
inline ExactSum GetSum(ByteReader& in) {
  // Nearly all fit 64 bits, by one load; every other form, and every wrong one, is left to the general reader.
  if (const char* const at = in.Peek(9)) {
    const int header = static_cast<uint8_t>(*at), skipped = header / 16, count = header % 16 + 1;
    if (skipped + count <= 8) [[likely]] {
      uint64_t bits;
      std::memcpy(&bits, at + 1, 8);
      bits &= ~uint64_t{0} >> (64 - 8 * count);
      if ((bits & 0xff) != 0 && bits >> (8 * (count - 1)) != 0 && (bits << (8 * skipped) & 1) == 0) [[likely]] {
        in.GetRaw(static_cast<size_t>(count) + 1);
        return ExactSum::FromUnits(static_cast<__int128>(bits << (8 * skipped) >> 1));
      }
    }
  }
  return GetAnySum(in);
}

// Where things are, ascending: each as how many were skipped since the one before. `limit`: how many there are.
class IndexWriter {
 public:
  void Put(ByteWriter& out, uint64_t index) {
    PutVarint(out, index - next_);
    next_ = index + 1;
  }

 private:
  uint64_t next_ = 0;
};
class IndexReader {
 public:
  explicit IndexReader(uint64_t limit) : limit_(limit) {}
  // `why` is what is wrong with one beyond the limit.
  uint64_t Get(ByteReader& in, const char* why) {
    const uint64_t skipped = GetVarint(in);
    if (skipped >= limit_ - next_) in.Fail(why);
    next_ += skipped + 1;
    return next_ - 1;
  }

 private:
  uint64_t limit_, next_ = 0;
};

}  // namespace lodestar
