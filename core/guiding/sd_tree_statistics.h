// What one thread learned in one round: sums over the slots and leaves of one SdTree. All sums are exact
// (docs/decisions/0002-exact-sums.md), so any partition of the records over threads, workers and merges gives the same
// bits.
//
// Not thread-safe: one per thread, merged afterwards. Memory is address space of 64 bytes a node, of which only touched
// pages are backed.
#pragma once

#include <optional>
#include <span>

#include "core/guiding/bsdf_fraction.h"
#include "core/guiding/light_selection.h"
#include "core/guiding/nee_probability.h"
#include "core/guiding/sd_tree.h"
#include "core/guiding/zero_pages.h"

namespace lodestar {

// One vertex of a path, once the light from its sampled direction is known.
struct SdTreeRecord {
  Vec3 position;
  Vec3 direction;      // of unit length, towards where the light came from
  float radiance = 0;  // lum(L), incident
  float pdf = 0;       // of the mixture that sampled the direction, per steradian
  float bsdf_pdf = 0;  // of its two techniques
  float tree_pdf = 0;
  float product = 0;   // lum(f cos L)
  float relative = 0;  // lum(throughput f cos L) / pixel estimate; read by the full target only
  bool delta = false;  // sampled from a delta lobe: counted, else left out
  uint32_t leaf = 0;   // LeafAt(position)
};

// The two parts of the light that a vertex reflects, for choosing how often to sample a light there.
struct NeeRecord {
  float direct = 0;       // lum of the MIS-weighted light sample, divided by its probability; 0 where none was taken
  float reflected = 0;    // lum of what came along the sampled direction, f cos / pdf included
  uint32_t vertices = 1;  // of the path from here on, this one included
  uint32_t leaf = 0;
};

// A light sample that arrived, for choosing which lights to sample there.
struct LightRecord {
  float direct = 0;       // as NeeRecord's
  float probability = 1;  // of having taken it, and of its group: P_g q
  uint32_t leaf = 0;
  uint8_t group = 0;
};

class SdTreeStatistics {
 public:
  struct Counts {
    uint64_t accepted = 0;
    uint64_t delta = 0;
    uint64_t refused = 0;    // not finite, negative, or a pdf that is not positive
    uint64_t saturated = 0;  // values beyond 2^70 after scaling, clamped
    void Merge(const Counts& other) {
      accepted += other.accepted;
      delta += other.delta;
      refused += other.refused;
      saturated += other.saturated;
    }
    friend bool operator==(const Counts&, const Counts&) = default;
  };
  // Sums of one spatial leaf.
  struct alignas(64) LeafSums {
    FractionSums fraction;
    ExactSum flux;        // scaled radiance / pdf
    uint64_t weight = 0;  // records, in units of 2^-24 (the box filter shares them out); in the cache line of `flux`
    NeeSums nee;
    double records() const { return static_cast<double>(weight) * 0x1p-24; }
    void Merge(const LeafSums& other) {
      weight += other.weight;
      flux.Merge(other.flux);
      nee.Merge(other.nee);
      fraction.Merge(other.fraction);
    }
  };

  explicit SdTreeStatistics(std::shared_ptr<const SdTree> tree);
  SdTreeStatistics(SdTreeStatistics&&) = default;
  ~SdTreeStatistics();  // clears what was touched, and keeps the pages for others

  // u_spatial in [0, 1)^3 is used by the stochastic filter only.
  void Record(const SdTreeRecord& record, Vec3 u_spatial, uint32_t half = 0);
  // A path's records at once, which hides the memory's latency; the jitter of record i is a hash of (key, i). All go to
  // one half.
  void Record(std::span<const SdTreeRecord> records, uint64_t key);
  // Asks for the sums of a leaf of which something is about to be recorded.
  void Prefetch(uint32_t leaf) const {
    __builtin_prefetch(&leaves_[leaf].flux, 1);
    __builtin_prefetch(&leaves_[leaf].nee.count, 1);
  }
  void Record(const NeeRecord& record);
  void Record(const LightRecord& record);  // only where the state selects lights

  // Both must belong to the same tree. Costs what `other` touched.
  void Merge(const SdTreeStatistics& other);

  // Canonical: equal sums have equal bytes, whatever their history. Sparse: what was not touched takes none.
  Bytes Serialize() const;
  // Adds what Serialize() wrote. Throws Error(kCorrupt), and kConflict where the bytes belong to another tree; then
  // nothing has changed.
  void MergeSerialized(std::string_view bytes);

  const std::shared_ptr<const SdTree>& tree() const { return tree_; }
  const Counts& counts() const { return counts_; }
  bool touched(uint32_t leaf) const { return (touched_[leaf / 64] >> (leaf % 64)) & 1; }
  uint64_t touched_leaves() const;
  const LeafSums& leaf(uint32_t leaf) const { return leaves_[leaf]; }
  // 2 where the state's reconstruction compares two halves of the paths, kept apart; else 1.
  uint32_t halves() const { return halves_; }
  // The sums of the slots of a leaf's D-tree, one after the other for each slot's halves: 4 * node_count * halves.
  std::span<const ExactSum> slots(uint32_t leaf) const { return {slots_.data() + FirstSum(leaf), SumCount(leaf)}; }

  // Of the contributions of light samples by group (light_selection.h), scaled; empty where selection is not learned.
  std::span<const ExactSum> lights(uint32_t leaf) const { return {lights_.data() + leaf * groups_, groups_}; }

 private:
  // A record behind the gate, on its way to one leaf.
  struct Pending {
    float value;  // what the target records, scaled, / pdf
    float flux;   // scaled radiance / pdf
    uint32_t x, y;
    uint32_t leaf;
  };
  struct Addition {
    size_t slot;
    float value;
  };
  // Reads what Serialize() wrote, which it adds where `kAdd`; else it only checks.
  template <bool kAdd>
  void Decode(std::string_view bytes);
  // Nothing for a record that is left out, which is counted.
  std::optional<Pending> Gate(const SdTreeRecord& record);
  float Product(const SdTreeRecord& record) const;
  void AddFraction(const SdTreeRecord& record);
  void Touch(uint32_t leaf) { touched_[leaf / 64] |= uint64_t{1} << (leaf % 64); }
  void AddWeight(uint32_t leaf, uint64_t weight, float flux) {
    Touch(leaf);
    leaves_[leaf].weight += weight;
    leaves_[leaf].flux.Add(flux);
  }
  size_t FirstSum(uint32_t leaf) const { return size_t{tree_->leaf(leaf).first_node} * 4 * halves_; }
  size_t SumCount(uint32_t leaf) const { return size_t{tree_->leaf(leaf).node_count} * 4 * halves_; }
  // Notes an addition and asks for its memory; FlushAdditions makes it.
  void AddSlot(uint32_t leaf, uint32_t slot, float value) {
    const size_t index = FirstSum(leaf) + size_t{slot} * halves_ + half_;
    __builtin_prefetch(&slots_[index], 1);
    additions_.push_back({index, value});
  }
  void FlushAdditions();
  void AddDirectional(uint32_t leaf, uint32_t x, uint32_t y, float value);
  uint32_t FilteredLeaf(const SdTreeRecord& record, Vec3 u) const;
  void AddBox(const SdTreeRecord& record, const Pending& pending);
  // As many records as their memory is fetched for at once.
  void RecordBatch(std::span<const SdTreeRecord> records, const Vec3* u_spatial);
  // Calls visit(leaf) for every touched leaf, ascending.
  template <class Visit>
  void ForTouched(Visit&& visit) const {
    for (size_t word = 0; word < touched_.size(); ++word) {
      for (uint64_t bits = touched_[word]; bits != 0; bits &= bits - 1)
        visit(static_cast<uint32_t>(word * 64 + std::countr_zero(bits)));
    }
  }

  std::shared_ptr<const SdTree> tree_;
  SdTreeOptions::Target target_;
  uint32_t halves_, half_ = 0;  // half_: of the record at hand
  ZeroPages<ExactSum> slots_;
  ZeroPages<LeafSums> leaves_;
  size_t groups_;
  ZeroPages<ExactSum> lights_;
  std::vector<uint64_t> touched_;
  Counts counts_;
  std::vector<Addition> additions_;  // of the batch at hand; empty between calls
};

}  // namespace lodestar
