// Next event estimation as an option of methods.
#pragma once

#include <cstdint>

namespace lodestar {

// Kickstart: in the first kKickstartIterations only, while the guide knows too little to find the lights itself
// (Mueller 2019, section 10.5). Learned: always allowed, at a share of the vertices that the guide learns.
enum class NeeMode : uint8_t { kNever, kKickstart, kAlways, kLearned };
inline constexpr uint32_t kKickstartIterations = 3;

constexpr bool UsesNee(NeeMode mode, uint32_t iteration) {
  return mode == NeeMode::kAlways || mode == NeeMode::kLearned ||
         (mode == NeeMode::kKickstart && iteration < kKickstartIterations);
}

}  // namespace lodestar
