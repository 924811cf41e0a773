// What one thread learned in one round: sums and counts over the entries of one RadianceGrid. Sums are exact
// (docs/decisions/0002-exact-sums.md), so any partition of the records over threads, workers and merges gives the same
// bits.
//
// Not thread-safe: one per thread, merged afterwards. Memory is address space of 24 bytes an entry, of which only
// touched pages are backed.
#pragma once

#include <bit>

#include "core/guiding/radiance_grid.h"
#include "core/guiding/zero_pages.h"
#include "core/math/exact_sum.h"

namespace lodestar {

class GridStatistics {
 public:
  struct Counts {
    uint64_t accepted = 0;
    uint64_t refused = 0;    // not finite, or negative
    uint64_t saturated = 0;  // values beyond 2^70 after scaling, clamped
    void Merge(const Counts& other) {
      accepted += other.accepted;
      refused += other.refused;
      saturated += other.saturated;
    }
    friend bool operator==(const Counts&, const Counts&) = default;
  };
  struct Sum {
    ExactSum value;  // scaled by the grid's radiance_scale
    uint64_t count = 0;
    friend bool operator==(const Sum&, const Sum&) = default;
  };

  explicit GridStatistics(std::shared_ptr<const RadianceGrid> grid);
  GridStatistics(GridStatistics&&) = default;
  GridStatistics& operator=(GridStatistics&&) = default;

  // An estimate of the luminance that arrives in a voxel from an entry's directions. Its mean is wanted, so it is not
  // divided by the density of the direction.
  void Record(uint32_t cell, uint32_t direction, float luminance);

  // Both must belong to the same grid. Costs what `other` touched.
  void Merge(const GridStatistics& other);

  // Canonical: equal sums have equal bytes, whatever their history. Sparse: what was not touched takes none.
  Bytes Serialize() const;
  // Adds what Serialize() wrote. Throws Error(kCorrupt), and kConflict where the bytes belong to another grid; then
  // nothing has changed.
  void MergeSerialized(std::string_view bytes);

  const std::shared_ptr<const RadianceGrid>& grid() const { return grid_; }
  const Counts& counts() const { return counts_; }

  // Calls visit(entry, sum) for every entry with a record, ascending.
  template <class Visit>
  void ForEach(Visit&& visit) const {
    for (size_t word = 0; word < touched_.size(); ++word)
      for (uint64_t bits = touched_[word]; bits != 0; bits &= bits - 1) {
        const size_t first = (word * 64 + static_cast<size_t>(std::countr_zero(bits))) * kBlock;
        for (size_t entry = first; entry < first + kBlock; ++entry)
          if (sums_[entry].count > 0) visit(entry, sums_[entry]);
      }
  }

 private:
  // Reads what Serialize() wrote, which it adds where `kAdd`; else it only checks.
  template <bool kAdd>
  void Decode(std::string_view bytes);
  static constexpr size_t kBlock = 32;  // entries of a bit in touched_; divides the directions of every grid
  void Touch(size_t entry) { touched_[entry / (kBlock * 64)] |= uint64_t{1} << (entry / kBlock % 64); }

  std::shared_ptr<const RadianceGrid> grid_;
  ZeroPages<Sum> sums_;
  std::vector<uint64_t> touched_;
  Counts counts_;
};

}  // namespace lodestar
