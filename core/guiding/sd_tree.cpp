#include "core/guiding/sd_tree.h"

#include "core/base/check.h"
#include "core/base/hash.h"
#include "core/guiding/light_selection.h"

namespace lodestar {
namespace {

uint64_t HashBytes(uint64_t hash, const void* data, size_t size) {
  const char* at = static_cast<const char*>(data);
  for (; size >= 8; size -= 8, at += 8) {
    uint64_t word;
    std::memcpy(&word, at, 8);
    hash = (hash ^ word) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 29;
  }
  for (; size > 0; --size, ++at) hash = Mix64(hash ^ static_cast<uint8_t>(*at));
  return Mix64(hash);
}

}  // namespace

std::shared_ptr<const SdTree> SdTree::Initial(const Bounds3& bounds, const SdTreeOptions& options,
                                              std::span<const float> light_groups) {
  options.Validate();
  const float size = MaxComponent(bounds.Diagonal());
  if (bounds.empty() || !IsFinite(bounds.min) || !std::isfinite(size) || size > 1e30f) {
    throw Error(ErrorKind::kInvalidInput,
                "the SD-tree needs bounds that are finite, not empty and below 1e30 in extent");
  }
  SdTreeParts parts;
  parts.options = options;
  parts.corner = bounds.min;
  parts.size = std::max(size, 1e-30f);  // a single point
  parts.depths = {0};
  parts.leaves.resize(1);
  parts.leaves[0].bsdf_fraction = options.initial_bsdf_fraction;
  parts.nodes.resize(1);
  if (light_groups.size() > 1)
    parts.lights = parts.lights_by_power =
        QuantizeShares(std::vector<double>(light_groups.begin(), light_groups.end()));
  return std::make_shared<const SdTree>(std::move(parts));
}

SdTreeOptions::Target SdTree::target() const {
  using Target = SdTreeOptions::Target;
  constexpr uint32_t kFirstFull = 4;  // 16 passes, after 15
  if (options_.target == Target::kSwitching) return iteration_ < kFirstFull ? Target::kSimple : Target::kFull;
  if (options_.target == Target::kFull && iteration_ == 0) return Target::kSimple;
  return options_.target;
}

SdTree::SdTree(SdTreeParts parts)
    : options_(parts.options),
      iteration_(parts.iteration),
      radiance_scale_(parts.radiance_scale),
      leaves_(std::move(parts.leaves)),
      nodes_(std::move(parts.nodes)),
      lights_by_power_(std::move(parts.lights_by_power)),
      lights_(std::move(parts.lights)) {
  auto spatial = SpatialTree::FromDepths(parts.corner, parts.size, parts.depths);
  LODESTAR_CHECK(spatial.has_value());
  spatial_ = std::move(*spatial);
  LODESTAR_CHECK(leaves_.size() == spatial_.leaf_count());
  ByteWriter head;
  options_.Write(head);
  head.Put(iteration_);
  head.Put(radiance_scale_);
  for (int axis = 0; axis < 3; ++axis) head.Put(parts.corner[axis]);
  head.Put(parts.size);
  uint64_t hash = HashBytes(0x5344, head.bytes().data(), head.bytes().size());
  hash = HashBytes(hash, parts.depths.data(), parts.depths.size());
  for (const SdTreeLeaf& leaf : leaves_) {
    LODESTAR_CHECK(uint64_t{leaf.first_node} + leaf.node_count <= nodes_.size());
    hash = Mix64(hash ^ ((uint64_t{leaf.node_count} << 32) | std::bit_cast<uint32_t>(leaf.bsdf_fraction)));
    hash = Mix64(hash ^ std::bit_cast<uint32_t>(leaf.nee_probability));
    hash = Mix64(hash ^
                 ((uint64_t{std::bit_cast<uint32_t>(leaf.records)} << 32) | std::bit_cast<uint32_t>(leaf.mean_flux)) ^
                 leaf.learned);
  }
  LODESTAR_CHECK(lights_.size() == leaves_.size() * lights_by_power_.size());
  hash = HashBytes(hash, lights_by_power_.data(), lights_by_power_.size() * sizeof(uint16_t));
  hash = HashBytes(hash, lights_.data(), lights_.size() * sizeof(uint16_t));
  fingerprint_ = HashBytes(hash, nodes_.data(), nodes_.size() * sizeof(DirectionalNode));
}

}  // namespace lodestar
