// From one iteration's state and statistics to the next state (Mueller et al. 2017, sections 3.2 and 3.3).
//
// Deterministic and in double. Steps: rebuild each D-tree from its sums, splitting and collapsing by flux_threshold;
// learn each leaf's BSDF fraction; split spatial leaves; set the scale of the next records. Deviation from the paper: a
// leaf with fewer than min_records records, or with none that carried light, keeps its previous distribution, where the
// paper's becomes uniform (docs/decisions/0002-exact-sums.md). Where the trees would exceed max_nodes, the thresholds
// of the iteration rise until they fit: that of leaves and flux_threshold double in turn, the latter to four times its
// option at most while any leaf splits; once none does, it rises alone.
#pragma once

#include <memory>
#include <optional>

#include "core/base/shards.h"
#include "core/guiding/reconstruction.h"
#include "core/guiding/sd_tree.h"
#include "core/guiding/sd_tree_statistics.h"

namespace lodestar {

// samples_per_pixel: of the iteration that was recorded (2^k times those of a pass), which the split threshold depends
// on.
// reconstruction: another than the tree's options say, for studies on the same statistics; kNative only where those
// keep halves.
// runner: who rebuilds the leaves where `dense` does, as shards; null: this process.
std::shared_ptr<const SdTree> Advance(const SdTree& tree, const SdTreeStatistics& statistics, double samples_per_pixel,
                                      std::optional<SdTreeOptions::Reconstruction> reconstruction = {},
                                      ShardRunner* runner = nullptr);

// What was recorded in a leaf's cells, as Advance() rebuilds its D-tree from: in the target's unit, the halves apart
// where the statistics keep them.
directional::CellMasses RecordedMasses(const SdTree& tree, const SdTreeStatistics& statistics, uint32_t leaf);

}  // namespace lodestar
