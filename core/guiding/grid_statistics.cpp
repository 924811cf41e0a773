#include "core/guiding/grid_statistics.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/exact_sum_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("GRIS");
constexpr uint32_t kVersion = 2;

}  // namespace

GridStatistics::GridStatistics(std::shared_ptr<const RadianceGrid> grid)
    : grid_(std::move(grid)),
      sums_(size_t{grid_->cell_count()} * grid_->direction_count()),
      touched_((sums_.size() + kBlock * 64 - 1) / (kBlock * 64)) {}

void GridStatistics::Record(uint32_t cell, uint32_t direction, float luminance) {
  if (!(luminance >= 0 && luminance < kInfinity)) {
    ++counts_.refused;
    return;
  }
  ++counts_.accepted;
  const size_t entry = grid_->Entry(cell, direction);
  Touch(entry);
  Sum& sum = sums_[entry];
  ++sum.count;
  counts_.saturated += !sum.value.Add(std::min(luminance * grid_->radiance_scale(), 3e38f));
}

void GridStatistics::Merge(const GridStatistics& other) {
  LODESTAR_CHECK(grid_->fingerprint() == other.grid_->fingerprint());
  counts_.Merge(other.counts_);
  other.ForEach([&](size_t entry, const Sum& sum) {
    Touch(entry);
    sums_[entry].value.Merge(sum.value);
    sums_[entry].count += sum.count;
  });
}

// Version 2: header, counts, then the entries with a record, each with its count and sum.
Bytes GridStatistics::Serialize() const {
  uint64_t entries = 0;
  ForEach([&](size_t, const Sum&) { ++entries; });
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  out.Put(grid_->fingerprint());
  out.Put(counts_.accepted);
  out.Put(counts_.refused);
  out.Put(counts_.saturated);
  PutVarint(out, entries);
  IndexWriter index;
  ForEach([&](size_t entry, const Sum& sum) {
    index.Put(out, entry);
    PutVarint(out, sum.count);
    PutSum(out, sum.value);
  });
  return out.Take();
}

template <bool kAdd>
void GridStatistics::Decode(std::string_view bytes) {
  ByteReader in(bytes, "grid statistics");
  in.ExpectHeader(kMagic, kVersion, /*many=*/true);
  if (in.Get<uint64_t>() != grid_->fingerprint()) {
    throw Error(ErrorKind::kConflict,
                "grid statistics belong to another state; render this unit again under the current one");
  }
  Counts counts;
  for (uint64_t* count : {&counts.accepted, &counts.refused, &counts.saturated}) *count = in.Get<uint64_t>();
  if constexpr (kAdd) counts_.Merge(counts);
  const uint64_t entries = GetVarint(in);
  IndexReader index(sums_.size());
  uint64_t records = 0;
  for (uint64_t i = 0; i < entries; ++i) {
    const uint64_t entry = index.Get(in, "name an entry that the grid does not have");
    const uint64_t count = GetVarint(in);
    if (count == 0 || count > counts.accepted - records) in.Fail("have an impossible record count");
    records += count;
    const ExactSum value = GetSum(in);
    if constexpr (kAdd) {
      Touch(entry);
      sums_[entry].count += count;
      sums_[entry].value.Merge(value);
    }
  }
  in.ExpectEnd();
  if (records != counts.accepted) in.Fail("have counts that do not add up");
}

void GridStatistics::MergeSerialized(std::string_view bytes) {
  Decode<false>(bytes);
  Decode<true>(bytes);
}

}  // namespace lodestar
