// The statistics' bytes, version 3: header, totals, then per touched leaf its weight, fraction sums and non-zero sums
// of lights and slots. Indices are written as varint differences, sums as their significant bytes behind one byte that
// says which.
#include "core/base/check.h"
#include "core/guiding/sd_tree_statistics.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = 0x53445344;  // "DSDS"
constexpr uint32_t kVersion = 3;

void PutVarint(ByteWriter& out, uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.Put(static_cast<uint8_t>(value | 0x80));
  out.Put(static_cast<uint8_t>(value));
}

// One form only for each value: a trailing zero byte or a tenth byte above one is refused.
uint64_t GetVarint(ByteReader& in) {
  uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const uint64_t byte = in.Get<uint8_t>();
    if (shift == 63 && byte > 1) in.Fail("has a number of more than 64 bits");
    value |= (byte & 0x7f) << shift;
    if (byte < 0x80) {
      if (byte == 0 && shift > 0) in.Fail("has a number that is not in its shortest form");
      return value;
    }
  }
  in.Fail("has a number of more than 64 bits");
}

// Zigzag, then the bytes between the lowest and highest that are not zero. Header: skipped low bytes * 16 + count - 1;
// 0xff for zero.
void PutWide(ByteWriter& out, __int128 value) {
  unsigned __int128 bits = (static_cast<unsigned __int128>(value) << 1) ^ static_cast<unsigned __int128>(value >> 127);
  if (bits == 0) return out.Put<uint8_t>(0xff);
  int skipped = 0, count = 0;
  for (; (bits & 0xff) == 0; bits >>= 8) ++skipped;
  uint8_t bytes[16];
  for (; bits != 0; bits >>= 8) bytes[count++] = static_cast<uint8_t>(bits);
  out.Put(static_cast<uint8_t>(skipped * 16 + count - 1));
  for (int i = 0; i < count; ++i) out.Put(bytes[i]);
}

__int128 GetWide(ByteReader& in) {
  const int header = in.Get<uint8_t>();
  if (header == 0xff) return 0;
  const int skipped = header / 16, count = header % 16 + 1;
  if (skipped + count > 16) in.Fail("has a sum of more than 128 bits");
  unsigned __int128 bits = 0;
  for (int i = 0; i < count; ++i) {
    const uint8_t byte = in.Get<uint8_t>();
    if (byte == 0 && (i == 0 || i == count - 1)) in.Fail("has a sum that is not in its shortest form");
    bits |= static_cast<unsigned __int128>(byte) << (8 * (skipped + i));
  }
  return static_cast<__int128>((bits >> 1) ^ (~(bits & 1) + 1));
}

ExactSum GetSum(ByteReader& in) {
  const __int128 units = GetWide(in);
  const ExactSum sum = ExactSum::FromUnits(units);
  if (units < 0 || sum.Units() != units) in.Fail("has a sum out of range");
  return sum;
}

// Sparse: how many are not zero, and those, each behind how many were skipped.
void PutSums(ByteWriter& out, std::span<const ExactSum> sums) {
  uint64_t count = 0;
  for (const ExactSum& sum : sums) count += !sum.zero();
  PutVarint(out, count);
  size_t next = 0;
  for (size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].zero()) continue;
    PutVarint(out, i - next);
    next = i + 1;
    PutWide(out, sums[i].Units());
  }
}

void GetSums(ByteReader& in, std::span<ExactSum> sums) {
  const uint64_t count = GetVarint(in);
  uint64_t next = 0;
  for (uint64_t s = 0; s < count; ++s) {
    const uint64_t skip = GetVarint(in);
    if (skip >= sums.size() - next) in.Fail("name a sum that the leaf does not have");
    next += skip;
    sums[next] = GetSum(in);
    if (sums[next++].zero()) in.Fail("have an empty sum");
  }
}

template <class Sums>
auto NeeParts(Sums& sums) {
  return std::array{&sums.direct, &sums.direct_squared, &sums.reflected, &sums.reflected_squared};
}

}  // namespace

Bytes SdTreeStatistics::Serialize() const {
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  out.Put(tree_->fingerprint());
  out.Put(tree_->leaf_count());
  out.Put(tree_->node_count());
  out.Put(counts_.accepted);
  out.Put(counts_.delta);
  out.Put(counts_.refused);
  out.Put(counts_.saturated);
  PutVarint(out, touched_leaves());
  uint32_t next_leaf = 0;
  ForTouched([&](uint32_t leaf) {
    PutVarint(out, leaf - next_leaf);
    next_leaf = leaf + 1;
    const LeafSums& sums = leaves_[leaf];
    PutVarint(out, sums.weight);
    PutWide(out, sums.flux.Units());
    if (tree_->options().learn_nee) {
      PutVarint(out, sums.nee.count);
      PutVarint(out, sums.nee.vertices);
      for (const ExactSum* sum : NeeParts(sums.nee)) PutWide(out, sum->Units());
    }
    PutVarint(out, sums.fraction.count);
    if (sums.fraction.count > 0) {
      PutWide(out, sums.fraction.weight.Units());
      for (int i = 0; i < kFractionGrid; ++i) PutWide(out, sums.fraction.GradientUnits(i));
    }
    if (groups_ > 0) PutSums(out, lights(leaf));
    PutSums(out, slots(leaf));
  });
  return out.Take();
}

SdTreeStatistics SdTreeStatistics::Parse(std::shared_ptr<const SdTree> tree, std::string_view bytes) {
  ByteReader in(bytes, "SD-tree statistics");
  if (in.Get<uint32_t>() != kMagic) in.Fail("do not begin like ones");
  if (const uint32_t version = in.Get<uint32_t>(); version != kVersion)
    in.Fail("have version " + std::to_string(version) + ", known is 3");
  const auto fingerprint = in.Get<uint64_t>();
  const auto leaf_count = in.Get<uint32_t>();
  const auto node_count = in.Get<uint32_t>();
  if (fingerprint != tree->fingerprint() || leaf_count != tree->leaf_count() || node_count != tree->node_count()) {
    throw Error(ErrorKind::kConflict,
                "SD-tree statistics belong to another tree; render this unit again under the current state");
  }
  SdTreeStatistics statistics(std::move(tree));
  statistics.counts_.accepted = in.Get<uint64_t>();
  statistics.counts_.delta = in.Get<uint64_t>();
  statistics.counts_.refused = in.Get<uint64_t>();
  statistics.counts_.saturated = in.Get<uint64_t>();
  const uint64_t leaves = GetVarint(in);
  uint64_t next_leaf = 0;
  for (uint64_t i = 0; i < leaves; ++i) {
    const uint64_t skip = GetVarint(in);
    if (skip >= leaf_count - next_leaf) in.Fail("name a leaf that the tree does not have");
    const uint32_t leaf = static_cast<uint32_t>(next_leaf + skip);
    next_leaf = leaf + 1;
    statistics.Touch(leaf);
    LeafSums& sums = statistics.leaves_[leaf];
    sums.weight = GetVarint(in);
    sums.flux = GetSum(in);
    if (statistics.tree_->options().learn_nee) {
      sums.nee.count = GetVarint(in);
      sums.nee.vertices = GetVarint(in);
      if (sums.nee.count > (uint64_t{1} << 40)) in.Fail("have an impossible record count");
      for (ExactSum* sum : NeeParts(sums.nee)) *sum = GetSum(in);
    }
    sums.fraction.count = GetVarint(in);
    if (sums.fraction.count > (uint64_t{1} << 40)) in.Fail("have an impossible record count");
    if (sums.fraction.count > 0) {
      sums.fraction.weight = GetSum(in);
      for (int g = 0; g < kFractionGrid; ++g) {
        const __int128 units = GetWide(in);
        const __int128 limit = static_cast<__int128>(sums.fraction.count) << 51;
        if (units > limit || units < -limit) in.Fail("have a gradient out of range");
        sums.fraction.SetGradientUnits(g, units);
      }
    }
    if (statistics.groups_ > 0)
      GetSums(in, {statistics.lights_.data() + leaf * statistics.groups_, statistics.groups_});
    GetSums(in, {statistics.slots_.data() + statistics.FirstSum(leaf), statistics.SumCount(leaf)});
  }
  in.ExpectEnd();
  return statistics;
}

}  // namespace lodestar
