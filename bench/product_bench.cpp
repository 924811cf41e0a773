// Product guiding: its cost against the tree alone and the naive product, and what it saves in variance against the
// tree alone and the Monte Carlo product. Trees are trained in the moving-lobes field of tests/guiding/synthetic.h;
// surfaces have random orientations and viewers. Single-threaded; user CPU time, medians over interleaved repetitions.
//
//   build/release/bin/product_bench [REPETITIONS]
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "bench/study_main.h"
#include "tests/guiding/product_baselines.h"

namespace lodestar {
namespace {

using namespace product_baselines;
using enum ProductLobe::Kind;

struct Material {
  const char* name;
  std::vector<ProductLobe> lobes;
};
const std::vector<Material> kMaterials = {
    {"diffuse", {{kDiffuseReflection, 1, 1}}},
    {"gloss 0.05", {{kGgxReflection, 0.05f, 1}}},
    {"gloss 0.1", {{kGgxReflection, 0.1f, 1}}},
    {"gloss 0.2", {{kGgxReflection, 0.2f, 1}}},
    {"gloss 0.4", {{kGgxReflection, 0.4f, 1}}},
    {"gloss 0.7", {{kGgxReflection, 0.7f, 1}}},
    {"diffuse + 0.1", {{kDiffuseReflection, 1, 0.6f}, {kGgxReflection, 0.1f, 0.4f}}},
    {"diffuse + 0.3", {{kDiffuseReflection, 1, 0.6f}, {kGgxReflection, 0.3f, 0.4f}}},
    {"0.05 + 0.4", {{kGgxReflection, 0.05f, 0.3f}, {kGgxReflection, 0.4f, 0.7f}}},
};

std::shared_ptr<const SdTree> TrainedTree() {
  synthetic::Training training;
  training.options.spatial_threshold = 120;
  training.options.spatial_filter = SdTreeOptions::SpatialFilter::kNearest;
  training.first_records = 50000;
  return synthetic::Train(training, 7);
}

struct Vertex {
  Vec3 position, wo, other;
  Frame frame;
  Vec2 u;
};
std::vector<Vertex> Vertices(const SdTree& tree, size_t count) {
  std::vector<Vertex> vertices(count);
  uint64_t rng = 3;
  for (Vertex& v : vertices) {
    v.position = synthetic::Unit3(rng);
    v.frame = Frame::FromNormal(SquareToSphere(synthetic::Unit2(rng)));
    v.wo = v.frame.ToWorld(SquareToCosineHemisphere(synthetic::Unit2(rng)));
    v.other = tree.Sample(tree.LeafAt(v.position), synthetic::Unit2(rng)).w;
    v.u = synthetic::Unit2(rng);
  }
  return vertices;
}

double UserNanoseconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) * 1e9 + static_cast<double>(usage.ru_utime.tv_usec) * 1e3;
}

float sink = 0;

struct Timed {
  std::function<void(const Vertex&)> work;
  size_t count;
  std::vector<double> times = {};
};
void Measure(std::vector<Timed>& all, const std::vector<Vertex>& vertices, int repetitions) {
  for (int r = 0; r < repetitions; ++r) {
    for (Timed& t : all) {
      const double start = UserNanoseconds();
      for (size_t i = 0; i < t.count; ++i) t.work(vertices[(i + static_cast<size_t>(r) * 977) % vertices.size()]);
      t.times.push_back((UserNanoseconds() - start) / static_cast<double>(t.count));
    }
  }
}

void Costs(const SdTree& tree, int repetitions) {
  const auto vertices = Vertices(tree, 1 << 14);
  std::vector<TreeTop> tops;
  for (uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) tops.emplace_back(tree.Tree(leaf));
  std::printf(
      "cost in ns: spatial lookup + sample + density of another direction; tree alone, product, naive product\n"
      "%-15s %7s | %7s = %5s + %5s + %5s | %7s  %s\n",
      "material", "tree", "product", "make", "sample", "pdf", "naive", "product / naive");
  for (const Material& m : kMaterials) {
    const auto lobes = [&](const Vertex& v) { return ProductLobes(v.frame, v.wo, m.lobes); };
    const auto at = [&](const Vertex& v) {
      const uint32_t leaf = tree.LeafAt(v.position);
      tops[leaf].Prefetch();
      return ProductDistribution(tree.Tree(leaf), tops[leaf], lobes(v));
    };
    constexpr size_t kCount = 1 << 14;
    std::vector<Timed> all;
    all.push_back({[&](const Vertex& v) {
                     const uint32_t leaf = tree.LeafAt(v.position);
                     sink += tree.Sample(leaf, v.u).pdf + tree.Pdf(leaf, v.other);
                   },
                   kCount});
    all.push_back({[&](const Vertex& v) {
                     const ProductDistribution product = at(v);
                     if (product.usable()) sink += product.Sample(v.u).pdf + product.Pdf(v.other);
                   },
                   kCount});
    all.push_back({[&](const Vertex& v) {
                     const ProductDistribution product = at(v);
                     sink += product.mass();
                   },
                   kCount});
    all.push_back({[&](const Vertex& v) {
                     const ProductDistribution product = at(v);
                     if (product.usable()) sink += product.Sample(v.u).pdf;
                   },
                   kCount});
    all.push_back({[&](const Vertex& v) {
                     const ProductLobes l = lobes(v);
                     const NaiveProduct product(tree.Tree(tree.LeafAt(v.position)), l);
                     sink += product.Sample(v.u).pdf + product.Pdf(v.other);
                   },
                   kCount / 16});
    Measure(all, vertices, repetitions);
    const double product = Median(all[1].times), make = Median(all[2].times), sampled = Median(all[3].times);
    std::printf("%-15s %7.0f | %7.0f = %5.0f + %5.0f + %5.0f | %7.0f  %.3f\n", m.name, Median(all[0].times), product,
                make, sampled - make, product - sampled, Median(all[4].times), product / Median(all[4].times));
  }
}

void Quality(const SdTree& tree) {
  constexpr std::array<float, 7> kFractions = {0.02f, 0.1f, 0.2f, 0.35f, 0.5f, 0.7f, 0.9f};
  constexpr int kVertices = 60, kSamples = 4000;
  const auto vertices = Vertices(tree, kVertices);
  std::printf(
      "\nrelative variance of one sample (geometric mean over %d vertices), at the best BSDF fraction for each | at "
      "0.5\n"
      "%-15s %8s %8s %8s %8s %8s | %8s %8s %8s %8s\n",
      kVertices, "material", "bsdf", "tree", "product", "naive", "MC 64", "tree", "product", "naive", "MC 64");
  for (const Material& m : kMaterials) {
    std::array<std::vector<double>, 9> found;
    for (int i = 0; i < kVertices; ++i) {
      const Vertex& v = vertices[i];
      const Surface surface(v.frame, v.wo, m.lobes);
      const ProductLobes lobes = surface.Lobes();
      const uint32_t leaf = tree.LeafAt(v.position);
      const DirectionalNode* const nodes = tree.Tree(leaf);
      const auto radiance = [&](Vec3 w) { return synthetic::MovingLobes(v.position, w); };
      const auto add = [&](int k, const auto& guide) {
        const auto variances = RelativeVariance(surface, guide, radiance, kFractions, kSamples, i);
        found[k].push_back(*std::min_element(variances.begin(), variances.end()));
        found[k + 4].push_back(variances[4]);
      };
      const TreeTop top(nodes);
      const ProductDistribution product(nodes, top, lobes);
      if (!product.usable()) continue;
      add(0, FluxOnly(nodes));
      add(1, product);
      add(2, NaiveProduct(nodes, lobes));
      add(3, MonteCarloProduct(nodes, tree.leaf(leaf).node_count, surface, 64, i));
      constexpr std::array<float, 1> kBsdf = {1.0f};
      found[8].push_back(RelativeVariance(surface, FluxOnly(nodes), radiance, kBsdf, kSamples, i)[0]);
    }
    const auto mean = [&](int k) {
      double sum = 0;
      for (double v : found[k]) sum += std::log(std::max(v, 1e-6));
      return std::exp(sum / static_cast<double>(found[k].size()));
    };
    std::printf("%-15s %8.3f %8.3f %8.3f %8.3f %8.3f | %8.3f %8.3f %8.3f %8.3f\n", m.name, mean(8), mean(0), mean(1),
                mean(2), mean(3), mean(4), mean(5), mean(6), mean(7));
  }
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 15;  // 0: variances only
  const auto tree = lodestar::TrainedTree();
  std::printf("%u leaves, %u nodes\n", tree->leaf_count(), tree->node_count());
  if (repetitions > 0) lodestar::Costs(*tree, repetitions);
  lodestar::Quality(*tree);
  return std::isfinite(lodestar::sink) ? 0 : 1;
}
