#include "core/guiding/grid_statistics.h"

#include <cmath>

#include "core/base/check.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = 0x53495247;  // "GRIS"
constexpr uint32_t kVersion = 1;

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

// Version 1: header, counts, then the entries with a record: their numbers, counts and both halves of their sums.
Bytes GridStatistics::Serialize() const {
  std::vector<uint32_t> entries;
  std::vector<uint64_t> count, low;
  std::vector<int64_t> high;
  ForEach([&](size_t entry, const Sum& sum) {
    entries.push_back(static_cast<uint32_t>(entry));
    count.push_back(sum.count);
    low.push_back(static_cast<uint64_t>(sum.value.Units()));
    high.push_back(static_cast<int64_t>(sum.value.Units() >> 64));
  });
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  out.Put(grid_->fingerprint());
  out.Put(counts_.accepted);
  out.Put(counts_.refused);
  out.Put(counts_.saturated);
  out.PutVector(entries);
  out.PutVector(count);
  out.PutVector(low);
  out.PutVector(high);
  return out.Take();
}

GridStatistics GridStatistics::Parse(std::shared_ptr<const RadianceGrid> grid, std::string_view bytes) {
  ByteReader in(bytes, "grid statistics");
  if (in.Get<uint32_t>() != kMagic) in.Fail("do not begin like ones");
  if (const uint32_t version = in.Get<uint32_t>(); version != kVersion)
    in.Fail("have version " + std::to_string(version) + ", known is 1");
  GridStatistics statistics(std::move(grid));
  if (in.Get<uint64_t>() != statistics.grid_->fingerprint()) {
    throw Error(ErrorKind::kConflict,
                "grid statistics belong to another state; render this unit again under the current one");
  }
  statistics.counts_.accepted = in.Get<uint64_t>();
  statistics.counts_.refused = in.Get<uint64_t>();
  statistics.counts_.saturated = in.Get<uint64_t>();
  const auto entries = in.GetVector<uint32_t>();
  const auto count = in.GetVector<uint64_t>(), low = in.GetVector<uint64_t>();
  const auto high = in.GetVector<int64_t>();
  if (count.size() != entries.size() || low.size() != entries.size() || high.size() != entries.size())
    in.Fail("have arrays of different lengths");
  in.ExpectEnd();
  uint64_t records = 0;
  for (size_t i = 0; i < entries.size(); ++i) {
    if (entries[i] >= statistics.sums_.size() || (i > 0 && entries[i] <= entries[i - 1]))
      in.Fail("name an entry that the grid does not have");
    if (count[i] == 0 || count[i] > statistics.counts_.accepted - records) in.Fail("have an impossible record count");
    records += count[i];
    const auto units =
        static_cast<__int128>((static_cast<unsigned __int128>(static_cast<uint64_t>(high[i])) << 64) | low[i]);
    Sum& sum = statistics.sums_[entries[i]];
    sum = {ExactSum::FromUnits(units), count[i]};
    if (units < 0 || sum.value.Units() != units) in.Fail("have a sum out of range");
    statistics.Touch(entries[i]);
  }
  if (records != statistics.counts_.accepted) in.Fail("have counts that do not add up");
  return statistics;
}

}  // namespace lodestar
