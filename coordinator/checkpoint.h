// A job's position as bytes: the loop's, and the antichain of the round that was under way with what it holds.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "core/learning/round.h"

namespace lodestar {

struct JobCheckpoint {
  Bytes loop;         // Loop::Checkpoint()
  Round round;        // meaningful where there are parts
  ContentHash state;  // the state the parts were rendered under
  struct Part {
    TreeNode node;
    Bytes contribution;  // SerializeContribution()
  };
  std::vector<Part> parts;

  Bytes Serialize() const;
  // Throws Error(kConflict) for another version, (kCorrupt).
  static JobCheckpoint Parse(std::string_view bytes);
};

}  // namespace lodestar
