// Cost of the SD-tree: lookup, sample and pdf; recording with each pair of filters; merging, the wire and advancing.
// The trees are trained in the moving-lobes field of tests/guiding/synthetic.h to a few thousand leaves.
// Single-threaded.
//   build/release/bin/guiding_bench
#include <benchmark/benchmark.h>

#include <memory>

#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

using SpatialFilter = SdTreeOptions::SpatialFilter;
using DirectionalFilter = SdTreeOptions::DirectionalFilter;
constexpr size_t kQueries = 1 << 16;

SdTreeOptions Options(SpatialFilter spatial, DirectionalFilter directional) {
  SdTreeOptions options;
  options.spatial_threshold = 120;
  options.spatial_filter = spatial;
  options.directional_filter = directional;
  return options;
}

std::shared_ptr<const SdTree> TreeOf(SpatialFilter spatial, DirectionalFilter directional) {
  static std::shared_ptr<const SdTree> trees[3][2];
  auto& tree = trees[static_cast<int>(spatial)][static_cast<int>(directional)];
  if (!tree) {
    synthetic::Training training;
    training.options = Options(SpatialFilter::kNearest, DirectionalFilter::kBox);
    training.first_records = 50000;
    const auto trained = synthetic::Train(training, 7);
    // The same tree for all filters.
    Bytes bytes = trained->Serialize();
    tree = trained;
    if (spatial != SpatialFilter::kNearest || directional != DirectionalFilter::kBox) {
      ByteWriter from, to;
      trained->options().Write(from);
      Options(spatial, directional).Write(to);
      bytes.replace(8, from.bytes().size(), to.bytes());
      tree = SdTree::Parse(bytes);
    }
  }
  return tree;
}
std::shared_ptr<const SdTree> DefaultTree() {
  return TreeOf(SpatialFilter::kStochastic, DirectionalFilter::kBox);
}

struct Query {
  Vec3 position, direction;
  Vec2 u;
};
const std::vector<Query>& Queries() {
  static const std::vector<Query> queries = [] {
    std::vector<Query> made(kQueries);
    uint64_t rng = 3;
    const auto tree = DefaultTree();
    for (Query& q : made) {
      q = {synthetic::Unit3(rng), {}, synthetic::Unit2(rng)};
      q.direction = tree->Sample(tree->LeafAt(q.position), synthetic::Unit2(rng)).w;
    }
    return made;
  }();
  return queries;
}

void Describe(benchmark::State& state, const SdTree& tree) {
  state.SetItemsProcessed(state.iterations());
  state.counters["leaves"] = tree.leaf_count();
  state.counters["nodes"] = tree.node_count();
}

void Lookup(benchmark::State& state) {
  const auto tree = DefaultTree();
  const auto& queries = Queries();
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(tree->LeafAt(queries[i++ % kQueries].position));
  Describe(state, *tree);
}
BENCHMARK(Lookup);

void LookupPdf(benchmark::State& state) {
  const auto tree = DefaultTree();
  const auto& queries = Queries();
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ % kQueries];
    benchmark::DoNotOptimize(tree->Pdf(tree->LeafAt(q.position), q.direction));
  }
  Describe(state, *tree);
}
BENCHMARK(LookupPdf);

void LookupSample(benchmark::State& state) {
  const auto tree = DefaultTree();
  const auto& queries = Queries();
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ % kQueries];
    benchmark::DoNotOptimize(tree->Sample(tree->LeafAt(q.position), q.u));
  }
  Describe(state, *tree);
}
BENCHMARK(LookupSample);

// What a path vertex asks: the leaf, a sample with its density, and the density of the BSDF's direction. Queries are
// independent, so what one waits for memory another may use: throughput, as of OpenPGL's own benchmark, not latency.
void LookupSamplePdf(benchmark::State& state) {
  const auto tree = DefaultTree();
  const auto& queries = Queries();
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ % kQueries];
    const uint32_t leaf = tree->LeafAt(q.position);
    const GuidedSample s = tree->Sample(leaf, q.u);
    benchmark::DoNotOptimize(s);
    benchmark::DoNotOptimize(tree->Pdf(leaf, q.direction));
  }
  Describe(state, *tree);
}
BENCHMARK(LookupSamplePdf);

void Record(benchmark::State& state) {
  const auto tree = TreeOf(static_cast<SpatialFilter>(state.range(0)), static_cast<DirectionalFilter>(state.range(1)));
  const auto records = synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 9, kQueries);
  SdTreeStatistics statistics(tree);
  statistics.Record(records, 1);
  constexpr size_t kPath = 8;
  size_t i = 0;
  for (auto _ : state) {
    statistics.Record(std::span(records).subspan(i % kQueries, kPath), i);
    i += kPath;
  }
  Describe(state, *tree);
  state.SetItemsProcessed(state.iterations() * kPath);
}
BENCHMARK(Record)
    ->ArgNames({"spatial", "directional"})
    ->Args({0, 0})
    ->Args({0, 1})
    ->Args({1, 0})
    ->Args({1, 1})
    ->Args({2, 1});

SdTreeStatistics Recorded(std::shared_ptr<const SdTree> tree, size_t count) {
  SdTreeStatistics statistics(tree);
  statistics.Record(synthetic::MakeRecords(*tree, synthetic::MovingLobes, 1, 9, count), 1);
  return statistics;
}

// Bytes read from both operands and written to one.
void Merge(benchmark::State& state) {
  const auto tree = DefaultTree();
  const SdTreeStatistics a = Recorded(tree, 500000);
  SdTreeStatistics b = Recorded(tree, 500000);
  for (auto _ : state) b.Merge(a);
  Describe(state, *tree);
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations() * (size_t{tree->node_count()} * 4 * 16 * 3)));
}
BENCHMARK(Merge)->Unit(benchmark::kMillisecond);

// The bound for Merge: the same traffic as plain 64-bit additions.
void MemoryBandwidth(benchmark::State& state) {
  const size_t words = size_t{DefaultTree()->node_count()} * 8;
  std::vector<uint64_t> a(words, 1), b(words, 2);
  for (auto _ : state) {
    for (size_t i = 0; i < words; ++i) b[i] += a[i];
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations() * words * 8 * 3));
}
BENCHMARK(MemoryBandwidth)->Unit(benchmark::kMillisecond);

// A round of about a second's work on one thread: created, filled, written, read. (How large: contribution_size.)
void Wire(benchmark::State& state) {
  const auto tree = DefaultTree();
  const SdTreeStatistics statistics = Recorded(tree, 1000000);
  for (auto _ : state) {
    SdTreeStatistics received(tree);
    received.MergeSerialized(statistics.Serialize());
    benchmark::DoNotOptimize(received);
  }
}
BENCHMARK(Wire)->Unit(benchmark::kMillisecond);

void AdvanceState(benchmark::State& state) {
  const auto tree = DefaultTree();
  const SdTreeStatistics statistics = Recorded(tree, 1000000);
  for (auto _ : state) benchmark::DoNotOptimize(Advance(*tree, statistics, 16));
  Describe(state, *tree);
}
BENCHMARK(AdvanceState)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lodestar
