// What one thread learned in one round: sums over the voxels of one FocalField. All sums are exact
// (docs/decisions/0002-exact-sums.md), so any partition of the records over threads, workers and merges gives the same
// bits.
//
// Not thread-safe: one per thread, merged afterwards. Memory is address space of 128 bytes a node, of which only
// touched pages are backed.
#pragma once

#include <span>

#include "core/guiding/bsdf_fraction.h"
#include "core/guiding/focal_field.h"
#include "core/guiding/zero_pages.h"

namespace lodestar {

// One segment of a path, whose direction was sampled at a vertex with smooth lobes, once the light along it is known.
struct FocalRecord {
  Vec3 position;
  Vec3 direction;      // of unit length
  float distance = 0;  // to the hit, in the space of the positions; infinity: to the box's edge
  float value = 0;     // l / p: luminance that the path brings to its pixel through this segment
  float pdf = 0;       // of the mixture that sampled the direction, and of its two techniques; read where the
  float bsdf_pdf = 0;  // fraction is learned
  float guide_pdf = 0;
};

class FocalStatistics {
 public:
  struct Counts {
    uint64_t accepted = 0;
    uint64_t refused = 0;    // not finite, negative, or a pdf that is not positive
    uint64_t missed = 0;     // no voxel on the segment
    uint64_t saturated = 0;  // values beyond 2^70 after scaling, clamped
    void Merge(const Counts& other) {
      accepted += other.accepted;
      refused += other.refused;
      missed += other.missed;
      saturated += other.saturated;
    }
    friend bool operator==(const Counts&, const Counts&) = default;
  };

  explicit FocalStatistics(std::shared_ptr<const FocalField> field);
  FocalStatistics(FocalStatistics&&) = default;
  FocalStatistics& operator=(FocalStatistics&&) = default;

  // Shares record.value out over the voxels on the segment: by length in initial iterations (Sadek 2025, 2.6.1, divided
  // by the whole length, without which the phases would mix by the scene's scale); in narrowing ones by
  // (a_v p_v)^n, which is the expectation step for a mixture of voxels. With FocalOptions::by_mixture the BSDF is one
  // more part of that mixture, whose share of the record is left out. Where all of these are zero, by length.
  void Record(const FocalRecord& record);
  // A segment that brought no light, whatever its densities: a record of value 0.
  void RecordNothing() { ++counts_.accepted; }

  // Both must belong to the same field. Costs what `other` touched.
  void Merge(const FocalStatistics& other);

  // Canonical: equal sums have equal bytes, whatever their history. Sparse: what was not touched takes none.
  Bytes Serialize() const;
  // Adds what Serialize() wrote. Throws Error(kCorrupt), and kConflict where the bytes belong to another field; then
  // nothing has changed.
  void MergeSerialized(std::string_view bytes);

  const std::shared_ptr<const FocalField>& field() const { return field_; }
  const Counts& counts() const { return counts_; }
  // Of all octrees, one after the other: 8 a node.
  const ExactSum& sum(uint32_t slot) const { return sums_[slot]; }
  uint32_t slot_count() const { return static_cast<uint32_t>(sums_.size()); }
  const FractionSums& fraction(uint32_t cell) const { return fractions_[cell]; }

 private:
  struct Share {
    uint32_t slot;
    float length;  // of the ray in the voxel
    float weight;  // a_v p_v, in units of the record
  };
  // Reads what Serialize() wrote, which it adds where `kAdd`; else it only checks.
  template <bool kAdd>
  void Decode(std::string_view bytes);
  bool Gate(const FocalRecord& record);
  void Collect(const FocalRecord& record);
  void Touch(uint32_t slot) { touched_[slot / 512] |= uint64_t{1} << (slot / 8 % 64); }
  // Calls visit(node) for every touched node of all octrees, ascending.
  template <class Visit>
  void ForTouched(Visit&& visit) const {
    for (size_t word = 0; word < touched_.size(); ++word) {
      for (uint64_t bits = touched_[word]; bits != 0; bits &= bits - 1)
        visit(static_cast<uint32_t>(word * 64 + static_cast<size_t>(std::countr_zero(bits))));
    }
  }
  // ... visit(slot) for every sum that is not zero.
  template <class Visit>
  void ForNonZero(Visit&& visit) const {
    ForTouched([&](uint32_t node) {
      for (uint32_t slot = node * 8; slot < node * 8 + 8; ++slot)
        if (!sums_[slot].zero()) visit(slot);
    });
  }

  std::shared_ptr<const FocalField> field_;
  ZeroPages<ExactSum> sums_;
  std::vector<uint64_t> touched_;  // nodes
  std::vector<FractionSums> fractions_;
  Counts counts_;
  std::vector<Share> shares_;  // of the record at hand
};

}  // namespace lodestar
