// The focal statistics' bytes, version 1: header, counts, then the voxels whose sum is not zero (their slots ascending,
// and both halves of their sums), then the cells that learned a fraction. Contributions are compressed on their way.
#include "core/base/check.h"
#include "core/guiding/focal_statistics.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = 0x53434f46;  // "FOCS"
constexpr uint32_t kVersion = 1;

struct Halves {
  uint64_t low;
  int64_t high;
};

Halves Split(__int128 value) {
  return {static_cast<uint64_t>(value), static_cast<int64_t>(value >> 64)};
}

__int128 Join(Halves halves) {
  return static_cast<__int128>((static_cast<unsigned __int128>(static_cast<uint64_t>(halves.high)) << 64) | halves.low);
}

ExactSum CheckedSum(ByteReader& in, Halves halves) {
  const __int128 units = Join(halves);
  const ExactSum sum = ExactSum::FromUnits(units);
  if (units < 0 || sum.Units() != units) in.Fail("have a sum out of range");
  return sum;
}

void PutFraction(ByteWriter& out, uint32_t cell, const FractionSums& sums) {
  out.Put(cell);
  out.Put(sums.count);
  out.Put(Split(sums.weight.Units()).low);
  out.Put(Split(sums.weight.Units()).high);
  for (int i = 0; i < kFractionGrid; ++i) {
    out.Put(Split(sums.GradientUnits(i)).low);
    out.Put(Split(sums.GradientUnits(i)).high);
  }
}

Halves GetHalves(ByteReader& in) {
  const auto low = in.Get<uint64_t>();
  return {low, in.Get<int64_t>()};
}

FractionSums GetFraction(ByteReader& in) {
  FractionSums sums;
  sums.count = in.Get<uint64_t>();
  if (sums.count == 0 || sums.count > (uint64_t{1} << 31)) in.Fail("have an impossible record count");
  sums.weight = CheckedSum(in, GetHalves(in));
  for (int i = 0; i < kFractionGrid; ++i) {
    const __int128 units = Join(GetHalves(in)), limit = static_cast<__int128>(sums.count) << 51;
    if (units > limit || units < -limit) in.Fail("have a gradient out of range");
    sums.SetGradientUnits(i, units);
  }
  return sums;
}

}  // namespace

Bytes FocalStatistics::Serialize() const {
  std::vector<uint32_t> slots;
  std::vector<uint64_t> low;
  std::vector<int64_t> high;
  ForTouched([&](uint32_t node) {
    for (uint32_t slot = node * 8; slot < node * 8 + 8; ++slot) {
      if (sums_[slot].zero()) continue;
      slots.push_back(slot);
      low.push_back(Split(sums_[slot].Units()).low);
      high.push_back(Split(sums_[slot].Units()).high);
    }
  });
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  out.Put(field_->fingerprint());
  out.Put(slot_count());
  out.Put(counts_.accepted);
  out.Put(counts_.refused);
  out.Put(counts_.missed);
  out.Put(counts_.saturated);
  out.PutVector(slots);
  out.PutVector(low);
  out.PutVector(high);
  uint32_t cells = 0;
  for (const FractionSums& sums : fractions_) cells += sums.count > 0;
  out.Put(cells);
  for (uint32_t cell = 0; cell < fractions_.size(); ++cell) {
    if (fractions_[cell].count > 0) PutFraction(out, cell, fractions_[cell]);
  }
  return out.Take();
}

FocalStatistics FocalStatistics::Parse(std::shared_ptr<const FocalField> field, std::string_view bytes) {
  ByteReader in(bytes, "focal statistics");
  if (in.Get<uint32_t>() != kMagic) in.Fail("do not begin like ones");
  if (const uint32_t version = in.Get<uint32_t>(); version != kVersion)
    in.Fail("have version " + std::to_string(version) + ", known is 1");
  FocalStatistics statistics(std::move(field));
  const auto fingerprint = in.Get<uint64_t>();
  const auto slot_count = in.Get<uint32_t>();
  if (fingerprint != statistics.field_->fingerprint() || slot_count != statistics.slot_count()) {
    throw Error(ErrorKind::kConflict,
                "focal statistics belong to another state; render this unit again under the current one");
  }
  statistics.counts_.accepted = in.Get<uint64_t>();
  statistics.counts_.refused = in.Get<uint64_t>();
  statistics.counts_.missed = in.Get<uint64_t>();
  statistics.counts_.saturated = in.Get<uint64_t>();
  const auto slots = in.GetVector<uint32_t>();
  const auto low = in.GetVector<uint64_t>();
  const auto high = in.GetVector<int64_t>();
  if (low.size() != slots.size() || high.size() != slots.size()) in.Fail("have arrays of different lengths");
  for (size_t i = 0; i < slots.size(); ++i) {
    if (slots[i] >= slot_count || (i > 0 && slots[i] <= slots[i - 1]))
      in.Fail("name a voxel that the field does not have");
    statistics.Touch(slots[i]);
    statistics.sums_[slots[i]] = CheckedSum(in, {low[i], high[i]});
    if (statistics.sums_[slots[i]].zero()) in.Fail("have an empty sum");
  }
  const auto cells = in.Get<uint32_t>();
  for (uint32_t i = 0, next = 0; i < cells; ++i) {
    const auto cell = in.Get<uint32_t>();
    if (cell < next || cell >= statistics.fractions_.size()) in.Fail("name a cell that the field does not have");
    statistics.fractions_[cell] = GetFraction(in);
    next = cell + 1;
  }
  in.ExpectEnd();
  return statistics;
}

}  // namespace lodestar
