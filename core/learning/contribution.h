// Contributions as bytes: versioned, canonical, lossless.
#pragma once

#include "core/learning/method.h"

namespace lodestar {

inline constexpr uint32_t kContributionVersion = 2;

Bytes SerializeContribution(const Contribution& contribution);
// Throws Error(kCorrupt) for anything that is not a contribution of `node` of this round: missing or foreign tiles,
// sizes that do not fit.
Contribution ParseContribution(const Method& method, const std::shared_ptr<const State>& state, const TileGrid& grid,
                               const Round& round, TreeNode node, std::string_view bytes);

}  // namespace lodestar
