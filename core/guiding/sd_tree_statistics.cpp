#include "core/guiding/sd_tree_statistics.h"

#include <limits>

#include "core/base/check.h"
#include "core/math/sampler.h"

namespace lodestar {
namespace {

constexpr uint64_t kOneRecord = uint64_t{1} << 24;
using SpatialFilter = SdTreeOptions::SpatialFilter;
using DirectionalFilter = SdTreeOptions::DirectionalFilter;

}  // namespace

SdTreeStatistics::SdTreeStatistics(std::shared_ptr<const SdTree> tree)
    : tree_(std::move(tree)), slots_(size_t{tree_->node_count()} * 4), leaves_(tree_->leaf_count()), touched_((tree_->leaf_count() + 63) / 64) {}

bool SdTreeStatistics::Gate(const SdTreeRecord& r, float* value) {
  if (r.delta) {
    ++counts_.delta;
    return false;
  }
  const bool valid = r.radiance >= 0 && r.radiance < kInfinity && r.pdf > 0 && r.pdf < kInfinity && r.product >= 0 && r.product < kInfinity &&
                     r.bsdf_pdf >= 0 && r.bsdf_pdf < kInfinity && r.tree_pdf >= 0 && r.tree_pdf < kInfinity && IsFinite(r.direction) &&
                     IsFinite(r.position);
  if (!valid) {
    ++counts_.refused;
    return false;
  }
  ++counts_.accepted;
  // Past the float range the sum saturates and counts it.
  *value = std::min(r.radiance / r.pdf * tree_->radiance_scale(), std::numeric_limits<float>::max());
  return true;
}

void SdTreeStatistics::AddFraction(const SdTreeRecord& r) {
  const auto loss = tree_->options().bsdf_fraction_loss;
  // Beside a uniform tree the BSDF always looks better; what is learned then would be wrong for the tree that comes.
  if (loss == SdTreeOptions::BsdfFractionLoss::kNone || !tree_->HasLearned(r.leaf) || !(r.product > 0) || !(r.bsdf_pdf + r.tree_pdf > 0)) return;
  Touch(r.leaf);
  leaves_[r.leaf].fraction.Add(loss, std::min(r.product * tree_->radiance_scale(), std::numeric_limits<float>::max()), r.pdf, r.bsdf_pdf,
                               r.tree_pdf);
}

void SdTreeStatistics::AddDirectional(uint32_t leaf, uint32_t x, uint32_t y, float value) {
  const DirectionalNode* const nodes = tree_->Tree(leaf);
  const directional::Cell cell = directional::Locate(nodes, x, y);
  if (tree_->options().directional_filter == DirectionalFilter::kNearest) {
    AddSlot(leaf, cell.slot, value);
  } else {
    directional::ForFootprint(nodes, x, y, cell, [&](uint32_t slot, float share) { AddSlot(leaf, slot, value * share); });
  }
}

uint32_t SdTreeStatistics::JitteredLeaf(const SdTreeRecord& r, Vec3 u) const {
  SpatialTree::Coordinates at = tree_->spatial().ToCoordinates(r.position);
  const SpatialTree::Cell& cell = tree_->spatial().cell(r.leaf);
  for (int axis = 0; axis < 3; ++axis) {
    const int64_t size = cell.Size(axis);
    const int64_t moved = at[axis] + static_cast<int64_t>(u[axis] * static_cast<float>(size)) - size / 2;
    at[axis] = static_cast<uint32_t>(std::clamp<int64_t>(moved, 0, (int64_t{1} << SpatialTree::kBits) - 1));
  }
  return tree_->spatial().LeafAt(at);
}

void SdTreeStatistics::AddBox(const SdTreeRecord& r, float value, uint32_t x, uint32_t y) {
  const SpatialTree& spatial = tree_->spatial();
  const SpatialTree::Cell& cell = spatial.cell(r.leaf);
  SpatialTree::Coordinates lower = spatial.ToCoordinates(r.position), size;
  for (int axis = 0; axis < 3; ++axis) {
    size[axis] = cell.Size(axis);
    // Moved inside the tree at its faces, so that the shares sum to one.
    lower[axis] = std::min(lower[axis] - std::min(lower[axis], size[axis] / 2), (uint32_t{1} << SpatialTree::kBits) - size[axis]);
  }
  spatial.ForOverlaps(lower, size, [&](uint32_t leaf, double share) {
    AddWeight(leaf, static_cast<uint64_t>(share * static_cast<double>(kOneRecord) + 0.5));
    if (value > 0) AddDirectional(leaf, x, y, value * static_cast<float>(share));
  });
}

void SdTreeStatistics::Record(const SdTreeRecord& r, Vec3 u_spatial) {
  LODESTAR_DCHECK(r.leaf < tree_->leaf_count());
  float value;
  if (!Gate(r, &value)) return;
  const Vec2 square = DirectionToCylindrical(r.direction);
  const uint32_t x = directional::ToInteger(square.x), y = directional::ToInteger(square.y);
  if (tree_->options().spatial_filter == SpatialFilter::kBox) {
    AddBox(r, value, x, y);
  } else {
    const uint32_t leaf = tree_->options().spatial_filter == SpatialFilter::kNearest ? r.leaf : JitteredLeaf(r, u_spatial);
    AddWeight(leaf, kOneRecord);
    if (value > 0) AddDirectional(leaf, x, y, value);
  }
  AddFraction(r);
}

void SdTreeStatistics::Record(std::span<const SdTreeRecord> records, uint64_t key) {
  for (size_t i = 0; i < records.size(); ++i) {
    const uint64_t xy = Mix64(key + i * 0x9e3779b97f4a7c15ULL), z = Mix64(xy);
    Record(records[i], {Sampler::ToUnit(static_cast<uint32_t>(xy)), Sampler::ToUnit(static_cast<uint32_t>(xy >> 32)),
                        Sampler::ToUnit(static_cast<uint32_t>(z))});
  }
}

void SdTreeStatistics::Merge(const SdTreeStatistics& other) {
  LODESTAR_CHECK(tree_->fingerprint() == other.tree_->fingerprint());
  counts_.accepted += other.counts_.accepted;
  counts_.delta += other.counts_.delta;
  counts_.refused += other.counts_.refused;
  counts_.saturated += other.counts_.saturated;
  other.ForTouched([&](uint32_t leaf) {
    Touch(leaf);
    leaves_[leaf].weight += other.leaves_[leaf].weight;
    leaves_[leaf].fraction.Merge(other.leaves_[leaf].fraction);
    const std::span<const ExactSum> from = other.slots(leaf);
    ExactSum* const to = slots_.data() + size_t{tree_->leaf(leaf).first_node} * 4;
    for (size_t slot = 0; slot < from.size(); ++slot) to[slot].Merge(from[slot]);
  });
}

uint64_t SdTreeStatistics::touched_leaves() const {
  uint64_t count = 0;
  ForTouched([&](uint32_t) { ++count; });
  return count;
}

uint64_t SdTreeStatistics::touched_slots() const {
  uint64_t count = 0;
  ForTouched([&](uint32_t leaf) {
    for (const ExactSum& sum : slots(leaf)) count += !sum.zero();
  });
  return count;
}

}  // namespace lodestar
