// How biased the document's memo is (grid_sampling.h): what its densities integrate to over the hemisphere. What is
// drawn at a vertex follows the density over its integral, so what is estimated there is the truth over that integral.
#pragma once

#include <optional>

#include "core/guiding/grid_sampling.h"

namespace lodestar {

struct GridIntegrals {
  double mean = 0, spread = 0;  // standard deviation
};

// Over even normals and the voxels that know of light above them; nothing where none does. A fixed number of places,
// the same for equal tables. By any rules on the hemisphere: 1 but for the quadrature's error where they are exact.
std::optional<GridIntegrals> MeasureIntegrals(const GridSampling& sampling);

}  // namespace lodestar
