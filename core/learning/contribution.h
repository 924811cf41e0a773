// Contributions as bytes: versioned, canonical, lossless.
#pragma once

#include <optional>
#include <span>

#include "core/learning/method.h"

namespace lodestar {

inline constexpr uint32_t kContributionVersion = 2;

Bytes SerializeContribution(const Contribution& contribution);
// A contribution as it came, checked but for its statistics: these are checked where they are merged.
struct ReceivedContribution {
  Contribution rest;                           // without statistics
  std::optional<std::string_view> statistics;  // Statistics::Serialize(), within the bytes that were read
};
// Throws Error(kCorrupt) for anything that is not a contribution of these nodes of this round, ascending: missing or
// foreign tiles, sizes that do not fit.
ReceivedContribution ReadContribution(const TileGrid& grid, const Round& round, std::span<const TreeNode> nodes,
                                      std::string_view bytes);

}  // namespace lodestar
