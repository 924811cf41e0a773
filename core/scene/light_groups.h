// Groups of lights whose share of the light samples can be learned. Lights near each other are mostly seen from the
// same places, so a few groups hold most of what a place can learn about visibility, whatever the number of lights;
// within a group power decides.
//
// The groups depend on the scene alone: recursive splits at the median of power along the longest axis of the lights'
// middles, down to lights that are closer to each other than their size (the two triangles of a square). All
// environments are one group (they are sampled as one strategy); distant lights have no place and are one each, the
// last group taking the rest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/distribution.h"
#include "core/math/vec.h"
#include "core/scene/scene_types.h"

namespace lodestar {

inline constexpr uint32_t kMaxLightGroups = 32, kMaxDistantGroups = 8;

class LightGroups {
 public:
  struct Light {
    enum class Place : uint8_t { kSpatial, kDistant, kEnvironment } place = Place::kSpatial;
    Vec3 middle;             // of spatial ones
    float extent = 0;        // their size
    double probability = 0;  // of picking it by power; 0: it is never picked and belongs to group 0
  };

  LightGroups() = default;
  // At least one probability is positive; they sum to 1.
  explicit LightGroups(std::span<const Light> lights);

  uint8_t group(size_t light) const { return group_[light]; }
  static constexpr uint8_t kEnvironments = 0;  // their group, where there are any
  // Probability of picking a light of each group by power; all positive.
  const std::vector<float>& shares() const { return shares_; }
  size_t memory_bytes() const;

  struct Choice {
    uint32_t light;
    uint8_t group;
    float ratio;  // of the light's probability to its probability by power
  };
  // `weights` is not empty; u in [0, 1).
  Choice Sample(LightGroupWeights weights, double u) const;
  float Ratio(LightGroupWeights weights, uint8_t group) const {
    return static_cast<float>(weights[group]) * per_share_[group];
  }

 private:
  void Add(std::span<const uint32_t> members);  // as a group
  void Split(std::span<const Light> lights, std::span<uint32_t> members, uint32_t budget);

  std::vector<uint8_t> group_;
  std::vector<float> shares_, per_share_;         // 2^-16 / share
  std::vector<uint32_t> members_, first_member_;  // lights by group
  std::vector<AliasTable> tables_;
};

}  // namespace lodestar
