// Exact sums as bytes. Whole numbers take 7 bits a byte, sums their significant bytes behind one byte that says which.
// Every value has one form only; readers fail (Error kCorrupt) for any other.
#pragma once

#include <cstdint>

#include "core/base/bytes.h"
#include "core/math/exact_sum.h"

namespace lodestar {

void PutVarint(ByteWriter& out, uint64_t value);
uint64_t GetVarint(ByteReader& in);

void PutWide(ByteWriter& out, __int128 value);
__int128 GetWide(ByteReader& in);

// A sum of addends that are not negative.
inline void PutSum(ByteWriter& out, const ExactSum& sum) {
  PutWide(out, sum.Units());
}
ExactSum GetSum(ByteReader& in);

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
