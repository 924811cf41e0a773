#include "core/guiding/sd_tree_advance.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/guiding/light_selection.h"
#include "core/guiding/radiance_scale.h"
#include "core/guiding/tree_request.h"

namespace lodestar {
namespace {

// What gives way where the trees would exceed max_nodes: leaves and trees in turn, trees by at most this factor of
// flux_threshold while leaves still split. After that the trees alone, in small steps: all of the room is theirs.
constexpr double kCoarsestTrees = 4, kFluxStep = 1.25;

struct RebuiltLeaf {
  SdTreeLeaf leaf;
  directional::Tree tree;
  std::vector<uint16_t> lights;
  int splits = 0;  // binary levels to split into
};

directional::Tree Copy(const SdTree& tree, uint32_t leaf) {
  const DirectionalNode* const nodes = tree.Tree(leaf);
  return {{nodes, nodes + tree.leaf(leaf).node_count}, tree.leaf(leaf).depth};
}

// A cell's mass from the sum recorded in it. A second moment over a cell of a given share of the sphere is a density's
// square times that share (Rath et al. 2020, section 5): the mass is the root of their product.
double Mass(SdTreeOptions::Target target, double sum, int depth) {
  return target == SdTreeOptions::Target::kRadiance ? sum : std::sqrt(std::ldexp(sum, -2 * depth));
}

}  // namespace

directional::CellMasses RecordedMasses(const SdTree& tree, const SdTreeStatistics& statistics, uint32_t leaf) {
  const DirectionalNode* const nodes = tree.Tree(leaf);
  const uint32_t node_count = tree.leaf(leaf).node_count, halves = statistics.halves();
  const std::span<const ExactSum> sums = statistics.slots(leaf);
  // Parents come before their children.
  std::vector<uint8_t> depths(node_count, 1);
  for (uint32_t node = 0; node < node_count; ++node) {
    for (const uint16_t child : nodes[node].child) {
      if (child != 0) depths[child] = static_cast<uint8_t>(depths[node] + 1);
    }
  }
  directional::CellMasses masses;
  masses.nodes = nodes;
  masses.node_count = node_count;
  masses.total.resize(size_t{node_count} * 4);
  if (halves == 2) masses.halves = {masses.total, masses.total};
  for (size_t slot = 0; slot < masses.total.size(); ++slot) {
    const int depth = depths[slot / 4];
    ExactSum total;
    for (uint32_t half = 0; half < halves; ++half) {
      const ExactSum& sum = sums[slot * halves + half];
      total.Merge(sum);
      if (halves == 2) masses.halves[half][slot] = Mass(tree.target(), sum.Value(), depth);
    }
    masses.total[slot] = Mass(tree.target(), total.Value(), depth);
  }
  return masses;
}

namespace {

using Reconstruction = SdTreeOptions::Reconstruction;

DenseRecipe RecipeFor(const SdTree& tree, double flux_threshold) {
  return {tree.options().dense_sigma, flux_threshold, tree.options().max_directional_depth};
}

bool IsDense(Reconstruction reconstruction) {
  return reconstruction == Reconstruction::kDense || reconstruction == Reconstruction::kDenseUnlimited;
}

directional::Tree MakeTree(const SdTree& tree, directional::CellMasses masses, Reconstruction reconstruction,
                           double flux_threshold) {
  if (IsDense(reconstruction)) return lodestar::MakeTree(RecipeFor(tree, flux_threshold), masses);
  const int max_depth = tree.options().max_directional_depth;
  if (reconstruction == Reconstruction::kNative)
    return directional::ReconstructNative(masses, flux_threshold, max_depth);
  return directional::Rebuild(masses.nodes, masses.node_count, std::move(masses.total), flux_threshold, max_depth);
}

// What a leaf's D-tree is to be made from; nothing where too little was recorded to make one.
std::optional<directional::CellMasses> MassesToLearnFrom(const SdTree& tree, const SdTreeStatistics& statistics,
                                                         uint32_t leaf) {
  if (statistics.leaf(leaf).records() < tree.options().min_records) return std::nullopt;
  directional::CellMasses masses = RecordedMasses(tree, statistics, leaf);
  double total = 0;
  for (const double mass : masses.total) total += mass;
  if (!(total > 0)) return std::nullopt;
  return masses;
}

// `made`: the leaf's next D-tree where it has been made; else it is made here.
RebuiltLeaf RebuildLeaf(const SdTree& tree, const SdTreeStatistics& statistics, uint32_t leaf,
                        Reconstruction reconstruction, double flux_threshold, double split_threshold,
                        std::optional<directional::Tree> made = {}) {
  const SdTreeOptions& options = tree.options();
  const SdTreeStatistics::LeafSums& sums = statistics.leaf(leaf);
  RebuiltLeaf out;
  out.leaf = tree.leaf(leaf);
  double records = sums.records();

  if (!made) {
    if (auto masses = MassesToLearnFrom(tree, statistics, leaf))
      made = MakeTree(tree, *std::move(masses), reconstruction, flux_threshold);
  }
  if (made) {
    out.tree = *std::move(made);
    out.leaf.learned = 1;
    const double flux = sums.flux.Value() / records / tree.radiance_scale();
    out.leaf.mean_flux = static_cast<float>(std::min(flux, 3e38));
  } else {
    out.tree = Copy(tree, leaf);
  }
  if (options.bsdf_fraction_loss != SdTreeOptions::BsdfFractionLoss::kNone) {
    out.leaf.bsdf_fraction = SolveBsdfFraction(sums.fraction, out.leaf.bsdf_fraction, kFractionPriorRecords);
  }
  if (options.learn_nee)
    out.leaf.nee_probability = SolveNeeProbability(sums.nee, out.leaf.nee_probability, options.min_records);
  out.lights.assign(tree.Lights(leaf).begin(), tree.Lights(leaf).end());
  // As many light samples as another distribution needs records.
  if (!out.lights.empty() && records * tree.leaf(leaf).nee_probability >= options.min_records)
    out.lights = SolveLightSelection(statistics.lights(leaf), tree.lights_by_power(), tree.Lights(leaf));
  const int depth = tree.spatial().cell(leaf).depth;
  for (; records > split_threshold && depth + out.splits < options.max_spatial_depth; records *= 0.5) ++out.splits;
  out.leaf.records = static_cast<float>(records);
  out.leaf.node_count = static_cast<uint32_t>(out.tree.nodes.size());
  out.leaf.depth = static_cast<uint8_t>(out.tree.depth);
  return out;
}

// How each tree is made: all alike, but for the document's own limit on the cost of its method.
std::vector<Reconstruction> Reconstructions(const SdTree& tree, Reconstruction wanted) {
  std::vector<Reconstruction> reconstructions(tree.leaf_count(), wanted);
  if (wanted != Reconstruction::kDense) return reconstructions;
  std::vector<int> depths;
  for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) depths.push_back(tree.leaf(leaf).depth);
  const std::vector<uint8_t> within = directional::WithinWorkload(depths, static_cast<int>(tree.iteration()));
  for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf)
    if (within[leaf] == 0) reconstructions[leaf] = Reconstruction::kNone;
  return reconstructions;
}

// All leaves to be rebuilt, in ranges of about as many nodes: some milliseconds of work, more where `dense` has deep
// trees. Of these alone another process is told, some hundred kilobytes at a time.
class LeafShards final : public ShardedWork {
 public:
  LeafShards(const SdTree& tree, const SdTreeStatistics& statistics, const std::vector<Reconstruction>& reconstructions,
             double flux_threshold, double split_threshold, std::vector<RebuiltLeaf>* leaves)
      : tree_(tree),
        statistics_(statistics),
        reconstructions_(reconstructions),
        flux_threshold_(flux_threshold),
        split_threshold_(split_threshold),
        leaves_(*leaves) {
    constexpr uint32_t kNodes = 8192, kLeaves = 512;
    uint32_t nodes = 0;
    for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
      if (leaf == 0 || nodes + tree.leaf(leaf).node_count > kNodes || leaf - begins_.back() == kLeaves) {
        begins_.push_back(leaf);
        nodes = 0;
      }
      nodes += tree.leaf(leaf).node_count;
    }
    begins_.push_back(tree.leaf_count());
  }
  uint32_t count() const override { return static_cast<uint32_t>(begins_.size() - 1); }
  void DoHere(uint32_t shard) override {
    const uint32_t begin = begins_[shard];
    ParallelFor(begins_[shard + 1] - begin, [&](uint32_t i) { Rebuild(begin + i); });
  }
  Bytes Describe(uint32_t shard) const override {
    const uint32_t begin = begins_[shard];
    std::optional<TreeRequest> request;
    for (uint32_t leaf = begin; leaf < begins_[shard + 1]; ++leaf) {
      if (!IsDense(reconstructions_[leaf])) continue;
      if (!request) request.emplace(RecipeFor(tree_, flux_threshold_));
      if (const auto masses = MassesToLearnFrom(tree_, statistics_, leaf)) request->Add(leaf - begin, *masses);
    }
    return request ? request->Take() : Bytes();
  }
  void Accept(uint32_t shard, std::string_view answer) override {
    const uint32_t begin = begins_[shard], count = begins_[shard + 1] - begin;
    auto trees = ReadTreeAnswer(answer, count, tree_.options().max_directional_depth);
    for (const PlacedTree& made : trees) {
      const uint32_t leaf = begin + made.place;
      if (!IsDense(reconstructions_[leaf]) || statistics_.leaf(leaf).records() < tree_.options().min_records)
        throw Error(ErrorKind::kCorrupt, "an answer has a tree that nobody asked for");
    }
    auto next = trees.begin();
    for (uint32_t i = 0; i < count; ++i) {
      const bool made = next != trees.end() && next->place == i;
      Rebuild(begin + i, made ? std::optional(std::move(next++->tree)) : std::nullopt);
    }
  }

 private:
  void Rebuild(uint32_t leaf, std::optional<directional::Tree> made = {}) {
    leaves_[leaf] = RebuildLeaf(tree_, statistics_, leaf, reconstructions_[leaf], flux_threshold_, split_threshold_,
                                std::move(made));
  }

  const SdTree& tree_;
  const SdTreeStatistics& statistics_;
  const std::vector<Reconstruction>& reconstructions_;
  const double flux_threshold_, split_threshold_;
  std::vector<RebuiltLeaf>& leaves_;
  std::vector<uint32_t> begins_;  // of the shards, and the end of the last
};

float NextScale(const SdTree& tree, const SdTreeStatistics& statistics) {
  double flux = 0, records = 0;
  for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    if (!statistics.touched(leaf)) continue;
    flux += statistics.leaf(leaf).flux.Value();
    records += statistics.leaf(leaf).records();
  }
  if (!(flux > 0) || !(records > 0)) return tree.radiance_scale();
  return RadianceScaleFor(flux / records / tree.radiance_scale());
}

// In double: it must not wrap before it is compared.
double NodesAfterSplits(const std::vector<RebuiltLeaf>& leaves) {
  double nodes = 0;
  for (const RebuiltLeaf& leaf : leaves) nodes += std::ldexp(leaf.leaf.node_count, leaf.splits);
  return nodes;
}

}  // namespace

std::shared_ptr<const SdTree> Advance(const SdTree& tree, const SdTreeStatistics& statistics, double samples_per_pixel,
                                      std::optional<Reconstruction> reconstruction, ShardRunner* runner) {
  LODESTAR_CHECK(tree.fingerprint() == statistics.tree()->fingerprint());
  LODESTAR_CHECK(samples_per_pixel > 0);
  const SdTreeOptions& options = tree.options();
  double split_threshold = options.spatial_threshold * std::sqrt(samples_per_pixel / 4);
  double flux_threshold = options.flux_threshold;
  const double coarsest = std::min(kCoarsestTrees * flux_threshold, 1.0);

  // Rebuild every leaf; coarser where the result would not fit.
  std::vector<RebuiltLeaf> leaves(tree.leaf_count());
  const Reconstruction wanted = reconstruction.value_or(options.reconstruction);
  const std::vector<Reconstruction> reconstructions = Reconstructions(tree, wanted);
  for (bool trees_turn = false;; trees_turn = !trees_turn) {
    LeafShards shards(tree, statistics, reconstructions, flux_threshold, split_threshold, &leaves);
    if (runner != nullptr && IsDense(wanted)) {
      runner->Run(shards);
    } else {
      ParallelFor(shards.count(), [&](uint32_t shard) { shards.DoHere(shard); });
    }
    if (NodesAfterSplits(leaves) <= static_cast<double>(options.max_nodes)) break;
    const bool splits = std::ranges::any_of(leaves, [](const RebuiltLeaf& leaf) { return leaf.splits > 0; });
    if (splits && (!trees_turn || flux_threshold >= coarsest)) {
      split_threshold *= 2;
    } else if (flux_threshold < 1) {
      flux_threshold *= splits ? 2 : kFluxStep;
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
  parts.lights_by_power.assign(tree.lights_by_power().begin(), tree.lights_by_power().end());
  parts.nodes.reserve(static_cast<size_t>(NodesAfterSplits(leaves)));
  for (uint32_t i = 0; i < tree.leaf_count(); ++i) {
    const RebuiltLeaf& rebuilt = leaves[i];
    for (uint64_t copy = 0; copy < (uint64_t{1} << rebuilt.splits); ++copy) {
      parts.depths.push_back(static_cast<uint8_t>(tree.spatial().cell(i).depth + rebuilt.splits));
      parts.leaves.push_back(rebuilt.leaf);
      parts.leaves.back().first_node = static_cast<uint32_t>(parts.nodes.size());
      parts.lights.insert(parts.lights.end(), rebuilt.lights.begin(), rebuilt.lights.end());
      parts.nodes.insert(parts.nodes.end(), rebuilt.tree.nodes.begin(), rebuilt.tree.nodes.end());
    }
  }
  return std::make_shared<const SdTree>(std::move(parts));
}

}  // namespace lodestar
