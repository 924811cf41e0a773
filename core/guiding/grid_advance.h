// The next state of a radiance grid from what a step recorded.
#pragma once

#include "core/guiding/grid_statistics.h"

namespace lodestar {

// Kim 2022, eq. 4.6 takes records one after the other, L <- (1 - a) L + a value. Their order is not ours to have, so an
// entry with n records moves to their mean with the same total weight, 1 - (1 - a)^n: exact sums and counts are all
// that is merged. The start at zero does not count: an entry's mean is divided by the weight it has collected, so that
// the first records are believed at once.
std::shared_ptr<const RadianceGrid> Advance(const RadianceGrid& grid, const GridStatistics& statistics);

}  // namespace lodestar
