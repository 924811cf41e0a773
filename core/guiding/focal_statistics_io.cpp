// The focal statistics' bytes, version 2: header, counts, then the voxels whose sum is not zero, then all cells where a
// fraction is learned.
#include "core/base/check.h"
#include "core/guiding/focal_statistics.h"
#include "core/math/exact_sum_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("FOCS");
constexpr uint32_t kVersion = 2;

}  // namespace

Bytes FocalStatistics::Serialize() const {
  uint64_t count = 0;
  ForNonZero([&](uint32_t) { ++count; });
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  out.Put(field_->fingerprint());
  out.Put(slot_count());
  out.Put(counts_.accepted);
  out.Put(counts_.refused);
  out.Put(counts_.missed);
  out.Put(counts_.saturated);
  PutVarint(out, count);
  IndexWriter index;
  ForNonZero([&](uint32_t slot) {
    index.Put(out, slot);
    PutSum(out, sums_[slot]);
  });
  for (const FractionSums& sums : fractions_) sums.Write(out);
  return out.Take();
}

template <bool kAdd>
void FocalStatistics::Decode(std::string_view bytes) {
  ByteReader in(bytes, "focal statistics");
  in.ExpectHeader(kMagic, kVersion, /*many=*/true);
  const auto fingerprint = in.Get<uint64_t>();
  const auto slots = in.Get<uint32_t>();
  if (fingerprint != field_->fingerprint() || slots != slot_count()) {
    throw Error(ErrorKind::kConflict,
                "focal statistics belong to another state; render this unit again under the current one");
  }
  Counts counts;
  for (uint64_t* count : {&counts.accepted, &counts.refused, &counts.missed, &counts.saturated})
    *count = in.Get<uint64_t>();
  if constexpr (kAdd) counts_.Merge(counts);
  const uint64_t count = GetVarint(in);
  IndexReader index(slots);
  for (uint64_t i = 0; i < count; ++i) {
    const auto slot = static_cast<uint32_t>(index.Get(in, "name a voxel that the field does not have"));
    const ExactSum sum = GetSum(in);
    if (sum.zero()) in.Fail("have an empty sum");
    if constexpr (kAdd) {
      Touch(slot);
      sums_[slot].Merge(sum);
    }
  }
  for (FractionSums& sums : fractions_) {
    const FractionSums read = FractionSums::Read(in);
    if constexpr (kAdd) sums.Merge(read);
  }
  in.ExpectEnd();
}

void FocalStatistics::MergeSerialized(std::string_view bytes) {
  Decode<false>(bytes);
  Decode<true>(bytes);
}

}  // namespace lodestar
