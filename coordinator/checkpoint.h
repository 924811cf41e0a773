// A job's position as bytes: the loop's, and what was merged of the round that was under way.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "core/learning/round.h"

namespace lodestar {

struct JobCheckpoint {
  Bytes loop;                   // Loop::Checkpoint()
  std::vector<TreeNode> nodes;  // covered; none: the rest means nothing
  Round round;
  ContentHash state;  // that the nodes were rendered under
  Bytes merged;       // SerializeContribution() of all of them

  Bytes Serialize() const;
  // Throws Error(kConflict) for another version, (kCorrupt).
  static JobCheckpoint Parse(std::string_view bytes);
};

}  // namespace lodestar
