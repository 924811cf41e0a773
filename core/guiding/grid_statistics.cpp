#include "core/guiding/grid_statistics.h"

#include <cmath>

#include "core/base/check.h"
#include "core/math/exact_sum_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = 0x53495247;  // "GRIS"
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
  counts_.accepted += other.counts_.accepted;
  counts_.refused += other.counts_.refused;
  counts_.saturated += other.counts_.saturated;
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

GridStatistics GridStatistics::Parse(std::shared_ptr<const RadianceGrid> grid, std::string_view bytes) {
  ByteReader in(bytes, "grid statistics");
  if (in.Get<uint32_t>() != kMagic) in.Fail("do not begin like ones");
  if (const uint32_t version = in.Get<uint32_t>(); version != kVersion)
    in.Fail("have version " + std::to_string(version) + ", known is 2");
  GridStatistics statistics(std::move(grid));
  if (in.Get<uint64_t>() != statistics.grid_->fingerprint()) {
    throw Error(ErrorKind::kConflict,
                "grid statistics belong to another state; render this unit again under the current one");
  }
  statistics.counts_.accepted = in.Get<uint64_t>();
  statistics.counts_.refused = in.Get<uint64_t>();
  statistics.counts_.saturated = in.Get<uint64_t>();
  const uint64_t entries = GetVarint(in);
  IndexReader index(statistics.sums_.size());
  uint64_t records = 0;
  for (uint64_t i = 0; i < entries; ++i) {
    const uint64_t entry = index.Get(in, "name an entry that the grid does not have");
    Sum& sum = statistics.sums_[entry];
    sum.count = GetVarint(in);
    if (sum.count == 0 || sum.count > statistics.counts_.accepted - records) in.Fail("have an impossible record count");
    records += sum.count;
    sum.value = GetSum(in);
    statistics.Touch(entry);
  }
  in.ExpectEnd();
  if (records != statistics.counts_.accepted) in.Fail("have counts that do not add up");
  return statistics;
}

}  // namespace lodestar
