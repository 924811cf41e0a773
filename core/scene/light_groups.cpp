#include "core/scene/light_groups.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/bounds.h"

namespace lodestar {

LightGroups::LightGroups(std::span<const Light> lights) : group_(lights.size(), 0) {
  using Place = Light::Place;
  // 1. Sort by kind.
  std::vector<uint32_t> spatial, distant, environments;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    if (!(lights[i].probability > 0)) continue;
    const Place place = lights[i].place;
    (place == Place::kSpatial ? spatial : place == Place::kDistant ? distant : environments).push_back(i);
  }
  // 2. Group, in order of the kinds.
  if (!environments.empty()) Add(environments);
  const auto alone = std::min<size_t>(distant.size(), kMaxDistantGroups);
  for (size_t i = 0; i < alone; ++i) Add(std::span(distant).subspan(i, i + 1 < alone ? 1 : distant.size() - i));
  if (!spatial.empty()) Split(lights, spatial, kMaxLightGroups - static_cast<uint32_t>(first_member_.size()));
  LODESTAR_CHECK(!first_member_.empty() && first_member_.size() <= kMaxLightGroups);
  first_member_.push_back(static_cast<uint32_t>(members_.size()));
  // 3. What picks by power within each.
  for (size_t g = 0; g + 1 < first_member_.size(); ++g) {
    std::vector<double> weights;
    double share = 0;
    for (uint32_t m = first_member_[g]; m < first_member_[g + 1]; ++m) {
      group_[members_[m]] = static_cast<uint8_t>(g);
      weights.push_back(lights[members_[m]].probability);
      share += weights.back();
    }
    tables_.emplace_back(weights);
    shares_.push_back(static_cast<float>(share));
    per_share_.push_back(static_cast<float>(0x1p-16 / share));
  }
}

void LightGroups::Add(std::span<const uint32_t> members) {
  first_member_.push_back(static_cast<uint32_t>(members_.size()));
  members_.insert(members_.end(), members.begin(), members.end());
}

void LightGroups::Split(std::span<const Light> lights, std::span<uint32_t> members, uint32_t budget) {
  Bounds3 bounds;
  double power = 0;
  float extent = 0;
  for (const uint32_t m : members) {
    bounds.Extend(lights[m].middle);
    power += lights[m].probability;
    extent = std::max(extent, lights[m].extent);
  }
  const Vec3 diagonal = bounds.Diagonal();
  if (budget == 1 || members.size() == 1 || Length(diagonal) < extent) return Add(members);
  const int axis = diagonal.x >= diagonal.y && diagonal.x >= diagonal.z ? 0 : diagonal.y >= diagonal.z ? 1 : 2;
  std::sort(members.begin(), members.end(), [&](uint32_t a, uint32_t b) {
    const float at = lights[a].middle[axis], bt = lights[b].middle[axis];
    return at != bt ? at < bt : a < b;
  });
  // Where the two sides' powers differ least; neither is empty.
  size_t left = 1;
  double sum = lights[members[0]].probability;
  while (left + 1 < members.size() &&
         std::fabs(2 * (sum + lights[members[left]].probability) - power) <= std::fabs(2 * sum - power))
    sum += lights[members[left++]].probability;
  // Half of the groups to each side, but no more than it has lights.
  const size_t right = members.size() - left;
  size_t left_budget = std::min<size_t>(left, budget / 2);
  const size_t right_budget = std::min<size_t>(right, budget - left_budget);
  left_budget = std::min<size_t>(left, budget - right_budget);
  Split(lights, members.first(left), static_cast<uint32_t>(left_budget));
  Split(lights, members.subspan(left), static_cast<uint32_t>(right_budget));
}

LightGroups::Choice LightGroups::Sample(LightGroupWeights weights, double u) const {
  LODESTAR_DCHECK(weights.size() == shares_.size());
  const double scaled = u * 0x1p16;
  const auto units = static_cast<uint32_t>(scaled);
  uint32_t group = 0, start = 0;
  while (group + 1 < weights.size() && units >= start + weights[group]) start += weights[group++];
  const uint32_t member = tables_[group].Sample((scaled - start) / weights[group]);
  return {members_[first_member_[group] + member], static_cast<uint8_t>(group),
          Ratio(weights, static_cast<uint8_t>(group))};
}

size_t LightGroups::memory_bytes() const {
  return group_.size() + members_.size() * (sizeof(uint32_t) + 12) +
         shares_.size() * (2 * sizeof(float) + sizeof(AliasTable));
}

}  // namespace lodestar
