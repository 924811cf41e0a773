// The statistics' bytes, version 4: header, totals, then per touched leaf its weight, fraction sums and non-zero sums
// of lights and slots. Indices are written as varint differences, sums as their significant bytes behind one byte that
// says which (core/math/exact_sum_bytes.h).
#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "core/base/check.h"
#include "core/guiding/sd_tree_statistics.h"
#include "core/math/exact_sum_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("DSDS");
constexpr uint32_t kVersion = 4;

// Sparse, in blocks: how many hold anything, and those, each behind how many were skipped and which of its sums follow.
// A block is a node's sums where its slots have two halves, else two nodes'.
constexpr size_t kBlock = 8;

uint8_t NotZero(std::span<const ExactSum> sums, size_t block) {
  const auto of_block = sums.subspan(block, std::min(kBlock, sums.size() - block));
  unsigned mask = 0;
  for (size_t i = 0; i < of_block.size(); ++i) mask |= unsigned{!of_block[i].zero()} << i;
  return static_cast<uint8_t>(mask);
}

void PutSums(ByteWriter& out, std::span<const ExactSum> sums) {
  uint64_t count = 0;
  for (size_t block = 0; block < sums.size(); block += kBlock) count += NotZero(sums, block) != 0;
  PutVarint(out, count);
  // These are nearly all of what a worker sends: by way of a small buffer, not one by one.
  constexpr size_t kRoom = kVarintRoom + 1 + kBlock * kWideRoom;
  std::array<char, 16 * kRoom> buffer;
  char* at = buffer.data();
  size_t next = 0;
  for (size_t block = 0; block < sums.size(); block += kBlock) {
    const uint8_t mask = NotZero(sums, block);
    if (mask == 0) continue;
    at = WriteVarint(at, (block - std::exchange(next, block + kBlock)) / kBlock);
    *at++ = static_cast<char>(mask);
    for (unsigned bits = mask; bits != 0; bits &= bits - 1)
      at = WriteWide(at, sums[block + static_cast<size_t>(std::countr_zero(bits))].Units());
    if (at + kRoom > buffer.data() + buffer.size()) {
      out.PutRaw({buffer.data(), at});
      at = buffer.data();
    }
  }
  out.PutRaw({buffer.data(), at});
}

template <bool kAdd>
void GetSums(ByteReader& in, std::span<ExactSum> sums) {
  const uint64_t count = GetVarint(in);
  IndexReader index((sums.size() + kBlock - 1) / kBlock);
  for (uint64_t b = 0; b < count; ++b) {
    const uint64_t block = kBlock * index.Get(in, "name sums that the leaf does not have");
    const unsigned mask = in.Get<uint8_t>();
    if (mask == 0) in.Fail("have an empty block of sums");
    if (block + static_cast<uint64_t>(std::bit_width(mask)) > sums.size())
      in.Fail("name sums that the leaf does not have");
    for (unsigned bits = mask; bits != 0; bits &= bits - 1) {
      const ExactSum sum = GetSum(in);
      if (sum.zero()) in.Fail("have an empty sum");
      if constexpr (kAdd) sums[block + static_cast<uint64_t>(std::countr_zero(bits))].Merge(sum);
    }
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
  IndexWriter index;
  ForTouched([&](uint32_t leaf) {
    index.Put(out, leaf);
    const LeafSums& sums = leaves_[leaf];
    PutVarint(out, sums.weight);
    PutSum(out, sums.flux);
    if (tree_->options().learn_nee) {
      PutVarint(out, sums.nee.count);
      PutVarint(out, sums.nee.vertices);
      for (const ExactSum* sum : NeeParts(sums.nee)) PutSum(out, *sum);
    }
    sums.fraction.Write(out);
    if (groups_ > 0) PutSums(out, lights(leaf));
    PutSums(out, slots(leaf));
  });
  return out.Take();
}

template <bool kAdd>
void SdTreeStatistics::Decode(std::string_view bytes) {
  ByteReader in(bytes, "SD-tree statistics");
  in.ExpectHeader(kMagic, kVersion, /*many=*/true);
  const auto fingerprint = in.Get<uint64_t>();
  const auto leaf_count = in.Get<uint32_t>();
  const auto node_count = in.Get<uint32_t>();
  if (fingerprint != tree_->fingerprint() || leaf_count != tree_->leaf_count() || node_count != tree_->node_count()) {
    throw Error(ErrorKind::kConflict,
                "SD-tree statistics belong to another tree; render this unit again under the current state");
  }
  Counts counts;
  for (uint64_t* count : {&counts.accepted, &counts.delta, &counts.refused, &counts.saturated})
    *count = in.Get<uint64_t>();
  if constexpr (kAdd) counts_.Merge(counts);
  const uint64_t leaves = GetVarint(in);
  IndexReader index(leaf_count);
  for (uint64_t i = 0; i < leaves; ++i) {
    const auto leaf = static_cast<uint32_t>(index.Get(in, "name a leaf that the tree does not have"));
    LeafSums sums;
    sums.weight = GetVarint(in);
    sums.flux = GetSum(in);
    if (tree_->options().learn_nee) {
      sums.nee.count = GetVarint(in);
      sums.nee.vertices = GetVarint(in);
      if (sums.nee.count > (uint64_t{1} << 40)) in.Fail("have an impossible record count");
      for (ExactSum* sum : NeeParts(sums.nee)) *sum = GetSum(in);
    }
    sums.fraction = FractionSums::Read(in);
    if constexpr (kAdd) {
      Touch(leaf);
      leaves_[leaf].Merge(sums);
    }
    if (groups_ > 0) GetSums<kAdd>(in, {lights_.data() + leaf * groups_, groups_});
    GetSums<kAdd>(in, {slots_.data() + FirstSum(leaf), SumCount(leaf)});
  }
  in.ExpectEnd();
}

// Twice through the bytes, which are small: they need no sums of their own, which are large.
void SdTreeStatistics::MergeSerialized(std::string_view bytes) {
  Decode<false>(bytes);
  Decode<true>(bytes);
}

}  // namespace lodestar
