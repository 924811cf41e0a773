#include "core/guiding/sd_tree_statistics.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"
#include "core/math/sampler.h"

namespace lodestar {
namespace {

constexpr uint64_t kOneRecord = uint64_t{1} << 24;
constexpr size_t kBatch = 16;
// Of the hash of a path by which its records are filtered and halved: neither may share bits with the numbers that the
// path was drawn with, which are hashes of the same key.
constexpr uint64_t kFilterSalt = 0x2545f4914f6cdd1dULL;
using SpatialFilter = SdTreeOptions::SpatialFilter;
using DirectionalFilter = SdTreeOptions::DirectionalFilter;
using Target = SdTreeOptions::Target;

}  // namespace

SdTreeStatistics::SdTreeStatistics(std::shared_ptr<const SdTree> tree)
    : tree_(std::move(tree)),
      target_(tree_->target()),
      halves_(tree_->options().reconstruction == SdTreeOptions::Reconstruction::kNative ? 2 : 1),
      slots_(size_t{tree_->node_count()} * 4 * halves_),
      leaves_(tree_->leaf_count()),
      groups_(tree_->lights_by_power().size()),
      lights_(tree_->leaf_count() * groups_),
      touched_((tree_->leaf_count() + 63) / 64) {}

// Of what has been moved from, nothing is touched and nothing there to keep.
SdTreeStatistics::~SdTreeStatistics() {
  ForTouched([&](uint32_t leaf) {
    leaves_[leaf] = {};
    std::fill_n(lights_.data() + leaf * groups_, groups_, ExactSum());
    std::fill_n(slots_.data() + FirstSum(leaf), SumCount(leaf), ExactSum());
  });
  slots_.Keep();
  leaves_.Keep();
  lights_.Keep();
}

std::optional<SdTreeStatistics::Pending> SdTreeStatistics::Gate(const SdTreeRecord& r) {
  LODESTAR_DCHECK(r.leaf < tree_->leaf_count());
  if (r.delta) {
    ++counts_.delta;
    return std::nullopt;
  }
  const auto usable = [](float value) { return value >= 0 && value < kInfinity; };
  if (!usable(r.radiance) || !usable(r.pdf) || r.pdf == 0 || !usable(r.product) || !usable(r.bsdf_pdf) ||
      !usable(r.tree_pdf) || !usable(r.relative) || !IsFinite(r.direction) || !IsFinite(r.position)) {
    ++counts_.refused;
    return std::nullopt;
  }
  ++counts_.accepted;
  const Vec2 square = DirectionToCylindrical(r.direction);
  // Past the float range the sum saturates and counts it.
  const auto bounded = [](float value) { return std::min(value, std::numeric_limits<float>::max()); };
  const float flux = bounded(r.radiance / r.pdf * tree_->radiance_scale());
  float value = flux;
  if (target_ != Target::kRadiance) {
    // Weighted by the share of the sample that is the tree's own (Rath et al. 2020, section 5): the rest is the BSDF's
    // to deal with.
    const float share = tree_->HasLearned(r.leaf) ? r.tree_pdf / r.pdf : 1.0f;
    const float weighted = Product(r) * share;
    value = bounded(weighted * (weighted / r.pdf));
  }
  return Pending{value, flux, directional::ToInteger(square.x), directional::ToInteger(square.y), 0};
}

// What the target weighs: in its own units, with a mean near 1.
float SdTreeStatistics::Product(const SdTreeRecord& r) const {
  return target_ == Target::kFull ? r.relative : r.product * tree_->radiance_scale();
}

void SdTreeStatistics::Record(const NeeRecord& r) {
  LODESTAR_DCHECK(r.leaf < tree_->leaf_count());
  Touch(r.leaf);
  leaves_[r.leaf].nee.Add(r.direct * tree_->radiance_scale(), r.reflected * tree_->radiance_scale(), r.vertices);
}

void SdTreeStatistics::Record(const LightRecord& r) {
  LODESTAR_DCHECK(r.leaf < tree_->leaf_count() && r.group < groups_);
  const float direct = r.direct * tree_->radiance_scale();
  if (!(direct > 0) || !(direct <= std::numeric_limits<float>::max())) return;
  Touch(r.leaf);
  lights_[r.leaf * groups_ + r.group].Add(
      std::min(direct * (direct * r.probability), std::numeric_limits<float>::max()));
}

void SdTreeStatistics::AddFraction(const SdTreeRecord& r) {
  const auto loss = tree_->options().bsdf_fraction_loss;
  // Beside a uniform tree the BSDF always looks better; what is learned then would be wrong for the tree that comes.
  // Nor does a vertex tell anything that was not guided, whose density is the BSDF's alone. What a guided one found
  // where the tree has no density does: only the BSDF reaches it.
  const float product = Product(r);
  const bool guided = r.tree_pdf > 0 || r.pdf < r.bsdf_pdf;
  if (loss == SdTreeOptions::BsdfFractionLoss::kNone || !tree_->HasLearned(r.leaf) || !(product > 0) || !guided) return;
  Touch(r.leaf);
  leaves_[r.leaf].fraction.Add(loss, std::min(product, std::numeric_limits<float>::max()), r.pdf, r.bsdf_pdf,
                               r.tree_pdf);
}

void SdTreeStatistics::AddDirectional(uint32_t leaf, uint32_t x, uint32_t y, float value) {
  const DirectionalNode* const nodes = tree_->Tree(leaf);
  const directional::Cell cell = directional::Locate(nodes, x, y);
  if (tree_->options().directional_filter == DirectionalFilter::kNearest) {
    AddSlot(leaf, cell.slot, value);
  } else {
    directional::ForFootprint(nodes, x, y, cell,
                              [&](uint32_t slot, float share) { AddSlot(leaf, slot, value * share); });
  }
}

uint32_t SdTreeStatistics::FilteredLeaf(const SdTreeRecord& r, Vec3 u) const {
  if (tree_->options().spatial_filter == SpatialFilter::kNearest) return r.leaf;
  SpatialTree::Coordinates at = tree_->spatial().ToCoordinates(r.position);
  const SpatialTree::Cell& cell = tree_->spatial().cell(r.leaf);
  bool stays = true;
  for (int axis = 0; axis < 3; ++axis) {
    const int32_t size = static_cast<int32_t>(cell.Size(axis));
    const int32_t moved =
        static_cast<int32_t>(at[axis]) + static_cast<int32_t>(u[axis] * static_cast<float>(size)) - size / 2;
    at[axis] = static_cast<uint32_t>(std::clamp(moved, 0, (1 << SpatialTree::kBits) - 1));
    stays &= at[axis] - cell.lower[axis] < static_cast<uint32_t>(size);
  }
  return stays ? r.leaf : tree_->spatial().LeafAt(at);
}

void SdTreeStatistics::AddBox(const SdTreeRecord& r, const Pending& pending) {
  const SpatialTree& spatial = tree_->spatial();
  const SpatialTree::Cell& cell = spatial.cell(r.leaf);
  SpatialTree::Coordinates lower = spatial.ToCoordinates(r.position), size;
  for (int axis = 0; axis < 3; ++axis) {
    size[axis] = cell.Size(axis);
    // Moved inside the tree at its faces, so that the shares sum to one.
    lower[axis] =
        std::min(lower[axis] - std::min(lower[axis], size[axis] / 2), (uint32_t{1} << SpatialTree::kBits) - size[axis]);
  }
  spatial.ForOverlaps(lower, size, [&](uint32_t leaf, double share) {
    AddWeight(leaf, static_cast<uint64_t>(share * static_cast<double>(kOneRecord) + 0.5),
              pending.flux * static_cast<float>(share));
    if (pending.value > 0) AddDirectional(leaf, pending.x, pending.y, pending.value * static_cast<float>(share));
  });
}

void SdTreeStatistics::RecordBatch(std::span<const SdTreeRecord> records, const Vec3* u_spatial) {
  const SdTreeOptions& options = tree_->options();
  std::array<Pending, kBatch> pending;
  std::array<uint8_t, kBatch> source;
  size_t count = 0;

  // 1. Gate, find the leaf, ask for its tree and sums.
  for (size_t i = 0; i < records.size(); ++i) {
    std::optional<Pending> accepted = Gate(records[i]);
    if (!accepted) continue;
    if (options.spatial_filter == SpatialFilter::kBox) {
      AddBox(records[i], *accepted);
      AddFraction(records[i]);
      continue;
    }
    accepted->leaf = FilteredLeaf(records[i], u_spatial[i]);
    directional::Prefetch(tree_->Tree(accepted->leaf));
    __builtin_prefetch(&leaves_[accepted->leaf].weight, 1);
    __builtin_prefetch(&leaves_[records[i].leaf].fraction.low, 1);
    __builtin_prefetch(&leaves_[records[i].leaf].fraction.high, 1);
    source[count] = static_cast<uint8_t>(i);
    pending[count++] = *accepted;
  }

  // 2. Find the slots and ask for them.
  for (size_t i = 0; i < count; ++i) {
    const Pending& p = pending[i];
    AddWeight(p.leaf, kOneRecord, p.flux);
    AddFraction(records[source[i]]);
    if (p.value > 0) AddDirectional(p.leaf, p.x, p.y, p.value);
  }

  // 3. Add.
  FlushAdditions();
}

void SdTreeStatistics::FlushAdditions() {
  for (const Addition& addition : additions_) counts_.saturated += !slots_[addition.slot].Add(addition.value);
  additions_.clear();
}

void SdTreeStatistics::Record(const SdTreeRecord& record, Vec3 u_spatial, uint32_t half) {
  half_ = half & (halves_ - 1);
  RecordBatch({&record, 1}, &u_spatial);
}

void SdTreeStatistics::Record(std::span<const SdTreeRecord> records, uint64_t key) {
  std::array<Vec3, kBatch> u;
  const uint64_t own = Mix64(key ^ kFilterSalt);
  half_ = static_cast<uint32_t>(own >> 63) & (halves_ - 1);
  for (size_t first = 0; first < records.size(); first += kBatch) {
    const size_t count = std::min(kBatch, records.size() - first);
    for (size_t i = 0; i < count; ++i) {
      const uint64_t xy = Mix64(own + (first + i + 1) * 0x9e3779b97f4a7c15ULL), z = xy * 0xc4ceb9fe1a85ec53ULL;
      u[i] = {Sampler::ToUnit(static_cast<uint32_t>(xy)), Sampler::ToUnit(static_cast<uint32_t>(xy >> 32)),
              Sampler::ToUnit(static_cast<uint32_t>(z >> 32))};
    }
    RecordBatch(records.subspan(first, count), u.data());
  }
}

void SdTreeStatistics::Merge(const SdTreeStatistics& other) {
  LODESTAR_CHECK(tree_->fingerprint() == other.tree_->fingerprint());
  counts_.Merge(other.counts_);
  other.ForTouched([&](uint32_t leaf) {
    Touch(leaf);
    leaves_[leaf].Merge(other.leaves_[leaf]);
    for (size_t g = 0; g < groups_; ++g) lights_[leaf * groups_ + g].Merge(other.lights(leaf)[g]);
    const std::span<const ExactSum> from = other.slots(leaf);
    ExactSum* const to = slots_.data() + FirstSum(leaf);
    for (size_t slot = 0; slot < from.size(); ++slot) to[slot].Merge(from[slot]);
  });
}

uint64_t SdTreeStatistics::touched_leaves() const {
  uint64_t count = 0;
  ForTouched([&](uint32_t) { ++count; });
  return count;
}

}  // namespace lodestar
