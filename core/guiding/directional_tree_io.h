// One D-tree's nodes as bytes. They are written in their order of layout, which follows from the probabilities, so no
// links are written and none can be wrong: a mask for each node says which of its children have a node.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/base/bytes.h"
#include "core/guiding/directional_tree.h"

namespace lodestar::directional {

uint8_t ChildMask(const DirectionalNode& node);
// False where the bytes, three integers of 16 bits, are no distribution.
bool ReadProbabilities(const char* bytes, DirectionalNode* node);
inline constexpr size_t kProbabilityBytes = 3 * sizeof(uint16_t);

// Links nodes whose probabilities were read, root first. The tree's depth, or 0 where masks and order do not make one
// tree of at most `max_depth`.
int Link(std::span<DirectionalNode> nodes, std::span<const uint8_t> masks, int max_depth);

// One tree by itself: its masks, and its probabilities.
void Write(ByteWriter& out, std::span<const DirectionalNode> nodes);
// Throws Error(kCorrupt) where that is no tree of at most `max_depth`.
Tree Read(ByteReader& in, int max_depth);

}  // namespace lodestar::directional
