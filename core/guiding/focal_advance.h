// From one iteration's field and statistics to the next field (Sadek 2025, sections 2.6.2, 3.4 to 3.6; Rath et al.
// 2023).
//
// Deterministic and in double. Steps: blend the new sums with the decayed old masses; after a narrowing iteration split
// the voxels above split_threshold, one level; after the last one collapse what prune_ratio finds even instead. Where
// the octree would exceed max_nodes, split_threshold doubles until it fits. Deviation: before anything was learned the
// masses weigh nothing, where the document lets the uniform start decay.
#pragma once

#include <memory>

#include "core/guiding/focal_field.h"
#include "core/guiding/focal_statistics.h"

namespace lodestar {

// last: training ends here, whatever iterations the options have left.
std::shared_ptr<const FocalField> Advance(const FocalField& field, const FocalStatistics& statistics,
                                          bool last = false);

}  // namespace lodestar
