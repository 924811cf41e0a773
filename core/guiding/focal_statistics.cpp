#include "core/guiding/focal_statistics.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/math/elementary.h"

namespace lodestar {
namespace {

uint32_t NodesOf(const FocalField& field) {
  uint32_t nodes = 0;
  for (const FocalOctree& octree : field.octrees()) nodes += octree.node_count();
  return nodes;
}

}  // namespace

FocalStatistics::FocalStatistics(std::shared_ptr<const FocalField> field)
    : field_(std::move(field)),
      sums_(size_t{NodesOf(*field_)} * 8),
      touched_((NodesOf(*field_) + 63) / 64),
      fractions_(field_->options().learn_fraction ? field_->fractions().size() : 0) {}

bool FocalStatistics::Gate(const FocalRecord& r) {
  const auto usable = [](float value) { return value >= 0 && value < kInfinity; };
  const bool fits = usable(r.value) && r.distance > 0 && IsFinite(r.position) && IsFinite(r.direction) &&
                    usable(r.pdf) && r.pdf > 0 && usable(r.bsdf_pdf) && usable(r.guide_pdf);
  ++(fits ? counts_.accepted : counts_.refused);
  return fits;
}

void FocalStatistics::Collect(const FocalRecord& r) {
  shares_.clear();
  uint32_t offset = 0;
  for (const FocalOctree& octree : field_->octrees()) {
    const bool diverging = offset > 0;
    // What a direction came from lies behind it, at any distance.
    const float end = diverging ? kInfinity : r.distance / field_->longest_side();
    octree.ForVoxels(field_->RayOf(r.position, diverging ? -r.direction : r.direction), end,
                     [&](uint32_t slot, float t0, float t1, float density) {
                       const float length = t1 - t0;
                       shares_.push_back({offset + slot, length, density * (length * (t1 * (t1 + t0) + t0 * t0))});
                     });
    offset += octree.node_count() * 8;
  }
}

void FocalStatistics::Record(const FocalRecord& r) {
  if (!Gate(r)) return;
  if (r.value == 0) return;
  float value = std::min(r.value * field_->radiance_scale(), 3e38f);
  const FocalOptions& options = field_->options();
  // Beside a uniform field the BSDF always looks better; what is learned then would be wrong for the field that comes.
  if (options.learn_fraction && field_->HasLearned()) {
    const float product = std::min(value * r.pdf, 3e38f);
    fractions_[field_->CellAt(r.position)].Add(SdTreeOptions::BsdfFractionLoss::kKl, product, r.pdf, r.bsdf_pdf,
                                               r.guide_pdf);
  }
  Collect(r);
  // A field that has met no light yet is still at its beginning, whatever the iteration.
  bool by_weight = options.Narrows(field_->iteration()) && field_->HasLearned();
  if (by_weight) {
    if (options.by_mixture) value *= std::min((1 - field_->BsdfFraction(r.position)) * (r.guide_pdf / r.pdf), 1.0f);
    // Relative to the largest, so that the power cannot leave the range of a float.
    float largest = 0;
    for (const Share& share : shares_) largest = std::max(largest, share.weight);
    by_weight = largest > 0;
    if (by_weight && options.narrow_factor != 1) {
      for (Share& share : shares_) share.weight = Pow(share.weight / largest, options.narrow_factor);
    }
  }
  double total = 0;
  for (const Share& share : shares_) total += by_weight ? share.weight : share.length;
  if (!(total > 0)) {
    ++counts_.missed;
    return;
  }
  for (const Share& share : shares_) {
    const double part = by_weight ? share.weight : share.length;
    if (part == 0) continue;
    Touch(share.slot);
    counts_.saturated += !sums_[share.slot].Add(static_cast<float>(value * (part / total)));
  }
}

void FocalStatistics::Merge(const FocalStatistics& other) {
  LODESTAR_CHECK(field_->fingerprint() == other.field_->fingerprint());
  counts_.Merge(other.counts_);
  for (size_t cell = 0; cell < fractions_.size(); ++cell) fractions_[cell].Merge(other.fractions_[cell]);
  other.ForTouched([&](uint32_t node) {
    Touch(node * 8);
    for (size_t slot = size_t{node} * 8; slot < size_t{node} * 8 + 8; ++slot) sums_[slot].Merge(other.sums_[slot]);
  });
}

}  // namespace lodestar
