#include "core/guiding/sd_tree_advance.h"

#include "core/base/check.h"

namespace lodestar {
namespace {

// The prior on a leaf's BSDF fraction, in records: its previous value counts as this many.
constexpr double kFractionPriorRecords = 64;

struct RebuiltLeaf {
  SdTreeLeaf leaf;
  directional::Tree tree;
  int splits = 0;  // binary levels to split into
};

directional::Tree Copy(const SdTree& tree, uint32_t leaf) {
  const DirectionalNode* const nodes = tree.Tree(leaf);
  return {{nodes, nodes + tree.leaf(leaf).node_count}, tree.leaf(leaf).depth};
}

RebuiltLeaf RebuildLeaf(const SdTree& tree, const SdTreeStatistics& statistics, uint32_t leaf, double flux_threshold,
                        double split_threshold) {
  const SdTreeOptions& options = tree.options();
  const SdTreeStatistics::LeafSums& sums = statistics.leaf(leaf);
  RebuiltLeaf out;
  out.leaf = tree.leaf(leaf);
  double records = sums.records();

  const std::span<const ExactSum> slots = statistics.slots(leaf);
  std::vector<double> masses;
  ExactSum total;
  if (records > 0) {
    masses.reserve(slots.size());
    for (const ExactSum& slot : slots) {
      masses.push_back(slot.Value());
      total.Merge(slot);
    }
  }
  if (records >= options.min_records && total.Value() > 0) {
    out.tree = directional::Rebuild(tree.Tree(leaf), tree.leaf(leaf).node_count, std::move(masses), flux_threshold,
                                    options.max_directional_depth);
    out.leaf.learned = 1;
    const double flux = total.Value() / records / tree.radiance_scale();
    out.leaf.mean_flux = static_cast<float>(std::min(flux, 3e38));
  } else {
    out.tree = Copy(tree, leaf);
  }
  if (options.bsdf_fraction_loss != SdTreeOptions::BsdfFractionLoss::kNone) {
    out.leaf.bsdf_fraction = SolveBsdfFraction(sums.fraction, out.leaf.bsdf_fraction, kFractionPriorRecords);
  }
  const int depth = tree.spatial().cell(leaf).depth;
  for (; records > split_threshold && depth + out.splits < options.max_spatial_depth; records *= 0.5) ++out.splits;
  out.leaf.records = static_cast<float>(records);
  out.leaf.node_count = static_cast<uint32_t>(out.tree.nodes.size());
  out.leaf.depth = static_cast<uint8_t>(out.tree.depth);
  return out;
}

// The power of two that brings the mean scaled record near 1, kept where it can be applied and undone in float.
float NextScale(const SdTree& tree, const SdTreeStatistics& statistics) {
  double flux = 0, records = 0;
  for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    if (!statistics.touched(leaf)) continue;
    for (const ExactSum& slot : statistics.slots(leaf)) flux += slot.Value();
    records += statistics.leaf(leaf).records();
  }
  if (!(flux > 0) || !(records > 0)) return tree.radiance_scale();
  const int exponent = std::ilogb(tree.radiance_scale()) - std::ilogb(flux / records);
  return std::ldexp(1.0f, std::clamp(exponent, -100, 100));
}

// In double: it must not wrap before it is compared.
double NodesAfterSplits(const std::vector<RebuiltLeaf>& leaves) {
  double nodes = 0;
  for (const RebuiltLeaf& leaf : leaves) nodes += std::ldexp(leaf.leaf.node_count, leaf.splits);
  return nodes;
}

}  // namespace

std::shared_ptr<const SdTree> Advance(const SdTree& tree, const SdTreeStatistics& statistics,
                                      double samples_per_pixel) {
  LODESTAR_CHECK(tree.fingerprint() == statistics.tree()->fingerprint());
  LODESTAR_CHECK(samples_per_pixel > 0);
  const SdTreeOptions& options = tree.options();
  double split_threshold = options.spatial_threshold * std::sqrt(samples_per_pixel / 4);
  double flux_threshold = options.flux_threshold;

  // Rebuild every leaf; coarser where the result would not fit.
  std::vector<RebuiltLeaf> leaves(tree.leaf_count());
  for (;;) {
    for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf)
      leaves[leaf] = RebuildLeaf(tree, statistics, leaf, flux_threshold, split_threshold);
    if (NodesAfterSplits(leaves) <= static_cast<double>(options.max_nodes)) break;
    if (flux_threshold < 1) {
      flux_threshold *= 2;
    } else if (split_threshold < 1e18) {
      split_threshold *= 2;
    } else {
      break;  // kept distributions of leaves without records: no larger than they were
    }
  }

  // Lay the leaves out, each as often as it was split.
  SdTreeParts parts;
  parts.options = options;
  parts.corner = tree.spatial().corner();
  parts.size = tree.spatial().size();
  parts.iteration = tree.iteration() + 1;
  parts.radiance_scale = NextScale(tree, statistics);
  parts.nodes.reserve(static_cast<size_t>(NodesAfterSplits(leaves)));
  for (uint32_t i = 0; i < tree.leaf_count(); ++i) {
    const RebuiltLeaf& rebuilt = leaves[i];
    for (uint64_t copy = 0; copy < (uint64_t{1} << rebuilt.splits); ++copy) {
      parts.depths.push_back(static_cast<uint8_t>(tree.spatial().cell(i).depth + rebuilt.splits));
      parts.leaves.push_back(rebuilt.leaf);
      parts.leaves.back().first_node = static_cast<uint32_t>(parts.nodes.size());
      parts.nodes.insert(parts.nodes.end(), rebuilt.tree.nodes.begin(), rebuilt.tree.nodes.end());
    }
  }
  return std::make_shared<const SdTree>(std::move(parts));
}

}  // namespace lodestar
