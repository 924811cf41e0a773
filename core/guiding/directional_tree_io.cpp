#include "core/guiding/directional_tree_io.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace lodestar::directional {
namespace {

// Depth first.
class Linker {
 public:
  Linker(std::span<DirectionalNode> nodes, std::span<const uint8_t> masks, int max_depth)
      : nodes_(nodes), masks_(masks), max_depth_(max_depth) {}
  int Link() {
    if (nodes_.empty() || !Visit(0)) return 0;
    return next_ == nodes_.size() ? depth_ : 0;
  }

 private:
  bool Visit(int level) {
    if (next_ >= nodes_.size() || level >= max_depth_) return false;
    const size_t index = next_++;
    depth_ = std::max(depth_, level + 1);
    for (int c : LikeliestFirst(nodes_[index])) {
      nodes_[index].child[c] = 0;
      if (((masks_[index] >> c) & 1) == 0) continue;
      nodes_[index].child[c] = static_cast<uint16_t>(next_);
      if (!Visit(level + 1)) return false;
    }
    return true;
  }
  std::span<DirectionalNode> nodes_;
  std::span<const uint8_t> masks_;
  int max_depth_;
  size_t next_ = 0;
  int depth_ = 0;
};

}  // namespace

uint8_t ChildMask(const DirectionalNode& node) {
  uint8_t mask = 0;
  for (int c = 0; c < 4; ++c) mask |= static_cast<uint8_t>((node.child[c] != 0) << c);
  return mask;
}

int Link(std::span<DirectionalNode> nodes, std::span<const uint8_t> masks, int max_depth) {
  return Linker(nodes, masks, max_depth).Link();
}

bool ReadProbabilities(const char* bytes, DirectionalNode* node) {
  std::array<uint16_t, 3> p;
  static_assert(sizeof(p) == kProbabilityBytes);
  std::memcpy(p.data(), bytes, sizeof(p));
  node->left = p[0];
  node->lower = {p[1], p[2]};
  return std::max({p[0], p[1], p[2]}) <= DirectionalNode::kOne;
}

void Write(ByteWriter& out, std::span<const DirectionalNode> nodes) {
  std::vector<uint8_t> masks;
  std::vector<uint16_t> probabilities;
  for (const DirectionalNode& node : nodes) {
    masks.push_back(ChildMask(node));
    probabilities.insert(probabilities.end(), {node.left, node.lower[0], node.lower[1]});
  }
  out.PutVector(masks);
  out.PutVector(probabilities);
}

Tree Read(ByteReader& in, int max_depth) {
  const auto masks = in.GetVector<uint8_t>();
  const std::string_view probabilities = in.GetVectorBytes(sizeof(uint16_t));
  if (masks.empty() || masks.size() > kMaxNodes || probabilities.size() != masks.size() * kProbabilityBytes)
    in.Fail("has a directional tree of an impossible size");
  Tree tree;
  tree.nodes.resize(masks.size());
  for (size_t i = 0; i < masks.size(); ++i) {
    if (masks[i] > 15 || !ReadProbabilities(probabilities.data() + i * kProbabilityBytes, &tree.nodes[i]))
      in.Fail("has a node that is no distribution");
  }
  tree.depth = Link(tree.nodes, masks, max_depth);
  if (tree.depth == 0) in.Fail("has a broken directional tree");
  return tree;
}

}  // namespace lodestar::directional
