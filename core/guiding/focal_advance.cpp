#include "core/guiding/focal_advance.h"

#include "core/base/check.h"
#include "core/guiding/radiance_scale.h"

namespace lodestar {
namespace {

// An octree while its shape changes. Node 0 is the root; nodes that nothing leads to are left behind.
class MutableOctree {
 public:
  // Masses are filled in afterwards.
  explicit MutableOctree(const FocalOctree& from) : nodes_(from.node_count()) {
    for (uint32_t i = 0; i < from.node_count(); ++i) {
      nodes_[i].level = from.node(i).level;
      for (int c = 0; c < 8; ++c)
        if ((from.node(i).inner >> c) & 1) nodes_[i].child[c] = from.node(i).Child(c);
    }
  }
  double& mass(uint32_t slot) { return nodes_[slot / 8].mass[slot % 8]; }
  bool is_leaf(uint32_t slot) const { return nodes_[slot / 8].child[slot % 8] == 0; }
  uint32_t slot_count() const { return static_cast<uint32_t>(nodes_.size() * 8); }

  void Split(double threshold, uint32_t max_nodes) {
    const auto splits = [&](uint32_t slot) {
      return is_leaf(slot) && mass(slot) > threshold && nodes_[slot / 8].level < FocalOctree::kMaxDepth;
    };
    const uint32_t slots = slot_count();
    for (;; threshold *= 2) {
      uint64_t nodes = nodes_.size();
      for (uint32_t slot = 0; slot < slots; ++slot) nodes += splits(slot);
      if (nodes <= max_nodes) break;
    }
    for (uint32_t slot = 0; slot < slots; ++slot) {
      if (!splits(slot)) continue;
      Node node;
      node.level = nodes_[slot / 8].level + 1;
      for (double& part : node.mass) part = mass(slot) / 8;
      nodes_[slot / 8].child[slot % 8] = static_cast<uint32_t>(nodes_.size());
      nodes_.push_back(node);
    }
  }

  // The root stays a node, whatever is in it.
  void Prune(double ratio) {
    for (int c = 0; c < 8; ++c)
      if (nodes_[0].child[c] != 0) PruneAt(0, c, ratio);
  }

  FocalParts::Octree Lay(double total) const {
    FocalParts::Octree out;
    std::vector<uint32_t> order = {0};
    for (size_t i = 0; i < order.size(); ++i) {
      uint8_t inner = 0;
      for (int c = 0; c < 8; ++c) {
        const Node& node = nodes_[order[i]];
        if (node.child[c] == 0) {
          out.leaf_masses.push_back(static_cast<float>(node.mass[c] / total));
        } else {
          inner |= static_cast<uint8_t>(1 << c);
          order.push_back(node.child[c]);
        }
      }
      out.inner.push_back(inner);
    }
    return out;
  }

 private:
  struct Node {
    std::array<double, 8> mass{};     // of leaves
    std::array<uint32_t, 8> child{};  // 0: a leaf
    int level = 1;                    // of its octants
  };
  struct Subtree {
    double mass, densest;  // density: mass / volume, the cube's volume being 1
  };
  // Of an octant that is a node, which it turns into a leaf where its densities are even.
  Subtree PruneAt(uint32_t index, int octant, double ratio) {
    Subtree sum{0, 0};
    const uint32_t child = nodes_[index].child[octant];
    const double per_volume = std::ldexp(1.0, 3 * nodes_[child].level);
    for (int c = 0; c < 8; ++c) {
      Subtree part{nodes_[child].mass[c], nodes_[child].mass[c] * per_volume};
      if (nodes_[child].child[c] != 0) part = PruneAt(child, c, ratio);
      sum = {sum.mass + part.mass, std::max(sum.densest, part.densest)};
    }
    const double mean = sum.mass * (per_volume / 8);
    if (sum.densest > ratio * mean) return sum;
    nodes_[index].child[octant] = 0;
    nodes_[index].mass[octant] = sum.mass;
    return {sum.mass, mean};
  }

  std::vector<Node> nodes_;
};

float NextScale(const FocalField& field, const FocalStatistics& statistics, double recorded) {
  const auto records = static_cast<double>(statistics.counts().accepted);
  if (!(recorded > 0) || !(records > 0)) return field.radiance_scale();
  return RadianceScaleFor(recorded / records);
}

}  // namespace

std::shared_ptr<const FocalField> Advance(const FocalField& field, const FocalStatistics& statistics, bool last) {
  LODESTAR_CHECK(field.fingerprint() == statistics.field()->fingerprint());
  const FocalOptions& options = field.options();
  const double unscale = 1.0 / field.radiance_scale(), kept = options.decay * field.weight() / field.mass();

  double recorded = 0;
  for (uint32_t slot = 0; slot < statistics.slot_count(); ++slot) recorded += statistics.sum(slot).Value() * unscale;

  FocalParts parts = PartsOf(field);
  parts.iteration = field.iteration() + 1;
  parts.radiance_scale = NextScale(field, statistics, recorded);
  for (uint32_t cell = 0; options.learn_fraction && cell < parts.fractions.size(); ++cell) {
    parts.fractions[cell] = SolveBsdfFraction(statistics.fraction(cell), parts.fractions[cell], kFractionPriorRecords);
  }

  // Blend.
  std::vector<MutableOctree> octrees;
  double total = 0;
  uint32_t offset = 0;
  for (const FocalOctree& octree : field.octrees()) {
    MutableOctree& next = octrees.emplace_back(octree);
    for (uint32_t slot = 0; slot < next.slot_count(); ++slot) {
      if (!next.is_leaf(slot)) continue;
      next.mass(slot) = kept * octree.mass(slot) + statistics.sum(offset + slot).Value() * unscale;
      total += next.mass(slot);
    }
    offset += next.slot_count();
  }
  if (!(total > 0) || !std::isfinite(total)) return std::make_shared<const FocalField>(std::move(parts));
  parts.weight = total;

  // Change the shape.
  last |= parts.iteration == options.iterations();
  for (size_t i = 0; i < octrees.size(); ++i) {
    if (last && options.prune_ratio > 0) {
      octrees[i].Prune(options.prune_ratio);
    } else if (options.Narrows(field.iteration()) && !last) {
      octrees[i].Split(options.split_threshold * total, options.max_nodes);
    }
    parts.octrees[i] = octrees[i].Lay(total);
  }
  return std::make_shared<const FocalField>(std::move(parts));
}

}  // namespace lodestar
