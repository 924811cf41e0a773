// Cost of focal guiding's pdf, the sum over all voxels on a ray, which is most of what the method costs: the walk over
// eight octants at a time against a recursive one that tests each octant by its slabs; then of sampling and recording.
// Fields are trained in the room with a ball of light of tests/guiding/focal_testing.h. Single-threaded; the counters
// say how many nodes an octree has and how many leaf voxels a ray crosses.
//   build/release/bin/focal_bench --benchmark_enable_random_interleaving=true --benchmark_repetitions=9
//       --benchmark_report_aggregates_only=true
#include <benchmark/benchmark.h>

#include <map>

#include "tests/guiding/focal_testing.h"

namespace lodestar {
namespace {

using focal_testing::Random;
constexpr size_t kQueries = 1 << 12;

enum Size : int64_t { kUniform, kPruned, kUnpruned, kFine };
enum Rays : int64_t { kAnywhere, kShort, kToLight };

std::shared_ptr<const FocalField> FieldOf(int64_t size) {
  static std::map<int64_t, std::shared_ptr<const FocalField>> fields;
  auto& field = fields[size];
  if (!field) {
    focal_testing::Training training;
    training.ambient = 1e-3f;
    if (size != kPruned) training.options.prune_ratio = 0;
    if (size == kFine) training.options.split_threshold = 1e-4f;
    field = focal_testing::Train(training, size == kUniform ? 0 : 12);
  }
  return field;
}

struct Query {
  Vec3 x, w;
};

// Short: from the box's outer eighth outwards; they leave it after a few voxels.
std::vector<Query> QueriesOf(int64_t rays) {
  std::vector<Query> queries;
  Random random(3);
  const focal_testing::Training training;
  while (queries.size() < kQueries) {
    Query q{focal_testing::PointIn(training.box, random), focal_testing::UniformDirection(random)};
    if (rays == kToLight) q.w = Normalize(training.light - q.x);
    if (rays == kShort) {
      q.x.x = 0.875f + q.x.x / 8;
      q.w = Normalize({1, q.w.y, q.w.z});
    }
    queries.push_back(q);
  }
  return queries;
}

void Describe(benchmark::State& state, const FocalField& field, const std::vector<Query>& queries) {
  double voxels = 0;
  for (const Query& q : queries)
    field.octrees()[0].ForVoxels(field.RayOf(q.x, q.w), kInfinity, [&](uint32_t, float, float, float) { ++voxels; });
  state.counters["nodes"] = field.octrees()[0].node_count();
  state.counters["voxels"] = voxels / static_cast<double>(queries.size());
  state.SetItemsProcessed(state.iterations());
}

void Pdf(benchmark::State& state) {
  const auto field = FieldOf(state.range(0));
  const std::vector<Query> queries = QueriesOf(state.range(1));
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ % kQueries];
    benchmark::DoNotOptimize(field->Pdf(q.x, q.w));
  }
  Describe(state, *field, queries);
}

// In float, a slab test an octant, recursion into those that are hit.
float WalkRecursively(const FocalOctree& octree, uint32_t index, Vec3 lower, float half, Vec3 x, Vec3 inverse) {
  const FocalOctree::Node& node = octree.node(index);
  float sum = 0;
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner = lower + Vec3{(c & 1) ? half : 0, (c & 2) ? half : 0, (c & 4) ? half : 0};
    const Vec3 a = (corner - x) * inverse, b = (corner + Vec3{half, half, half} - x) * inverse;
    const Vec3 near = Min(a, b), far = Max(a, b);
    const float t0 = std::max(std::max(near.x, near.y), std::max(near.z, 0.0f));
    const float t1 = std::min(std::min(far.x, far.y), far.z);
    if (!(t0 < t1)) continue;
    if ((node.inner >> c) & 1) {
      sum += WalkRecursively(octree, node.Child(c), corner, half / 2, x, inverse);
    } else {
      sum += node.density[c] * ((t1 - t0) * (t1 * (t1 + t0) + t0 * t0));
    }
  }
  return sum;
}

void PdfRecursive(benchmark::State& state) {
  const auto field = FieldOf(state.range(0));
  const std::vector<Query> queries = QueriesOf(state.range(1));
  const Vec3 stretch = Vec3{1, 1, 1} * field->longest_side();
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ % kQueries];
    const Vec3 w = {q.w.x * stretch.x / field->sides().x, q.w.y * stretch.y / field->sides().y,
                    q.w.z * stretch.z / field->sides().z};
    benchmark::DoNotOptimize(
        WalkRecursively(field->octrees()[0], 0, {}, 0.5f, field->ToUnit(q.x), {1 / w.x, 1 / w.y, 1 / w.z}));
  }
  Describe(state, *field, queries);
}

void Sample(benchmark::State& state) {
  const auto field = FieldOf(state.range(0));
  const std::vector<Query> queries = QueriesOf(kAnywhere);
  Random random(5);
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(field->Sample(queries[i++ % kQueries].x, random.Next2D()));
  Describe(state, *field, queries);
}

void Record(benchmark::State& state) {
  FocalParts parts = PartsOf(*FieldOf(state.range(0)));
  parts.iteration = 6;
  const auto field = std::make_shared<const FocalField>(std::move(parts));
  const std::vector<Query> queries = QueriesOf(kAnywhere);
  FocalStatistics statistics(field);
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ % kQueries];
    statistics.Record(
        {.position = q.x, .direction = q.w, .distance = 1, .value = 1, .pdf = 1, .bsdf_pdf = 1, .guide_pdf = 1});
  }
  Describe(state, *field, queries);
}

void AllRays(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"field", "rays"});
  for (const int64_t size : {kUniform, kPruned, kUnpruned, kFine}) benchmark->Args({size, kAnywhere});
  for (const int64_t rays : {kShort, kToLight}) benchmark->Args({kPruned, rays});
}

BENCHMARK(Pdf)->Apply(AllRays);
BENCHMARK(PdfRecursive)->Apply(AllRays);
BENCHMARK(Sample)->ArgName("field")->Arg(kPruned)->Arg(kFine);
BENCHMARK(Record)->ArgName("field")->Arg(kPruned)->Arg(kUnpruned);

}  // namespace
}  // namespace lodestar
