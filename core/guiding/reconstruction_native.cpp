#include "core/guiding/reconstruction.h"

namespace lodestar::directional {

Tree ReconstructNative(const CellMasses& masses, double flux_threshold, int max_depth) {
  return Rebuild(masses.nodes, masses.node_count, masses.total, flux_threshold, max_depth);
}

}  // namespace lodestar::directional
