// Nanoseconds per Sample + Evaluate of each BSDF kind, at directions that vary as a path's do.
#include <benchmark/benchmark.h>

#include <vector>

#include "core/math/sampler.h"
#include "core/math/warp.h"
#include "core/scene/bsdf.h"

namespace lodestar {
namespace {

struct Query {
  Vec3 wo, wi;
  float u_lobe;
  Vec2 u;
};

// Too many for the branch predictor to learn by heart, as it does with a few thousand.
constexpr uint32_t kQueries = 1 << 17;

std::vector<Query> Queries() {
  std::vector<Query> queries;
  for (uint32_t i = 0; i < kQueries; ++i) {
    Sampler sampler(1, i, 0, 0);
    Query q;
    q.wo = SquareToCosineHemisphere(sampler.Next2D());
    q.wi = SquareToCosineHemisphere(sampler.Next2D());
    q.u_lobe = sampler.Next2D().x;
    q.u = sampler.Next2D();
    queries.push_back(q);
  }
  return queries;
}

enum Mode { kSample, kEvaluate, kBoth };

void Run(benchmark::State& state, const Bsdf& prototype, Mode mode) {
  const std::vector<Query> queries = Queries();
  Bsdf bsdf = prototype;
  benchmark::DoNotOptimize(bsdf);  // the kind is not known at compile time
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = queries[i++ & (kQueries - 1)];
    if (mode != kEvaluate) {
      auto s = bsdf.Sample(q.wo, q.u_lobe, q.u);
      benchmark::DoNotOptimize(s);
    }
    if (mode != kSample) {
      auto v = bsdf.Evaluate(q.wo, q.wi);
      benchmark::DoNotOptimize(v);
    }
  }
}

const Rgb kEta(0.2f, 0.9f, 1.1f), kK(3.9f, 2.4f, 2.1f);

#define LODESTAR_BSDF_BENCH(name, bsdf)                     \
  BENCHMARK_CAPTURE(Run, name##_sample, bsdf, kSample);     \
  BENCHMARK_CAPTURE(Run, name##_evaluate, bsdf, kEvaluate); \
  BENCHMARK_CAPTURE(Run, name##_both, bsdf, kBoth)

LODESTAR_BSDF_BENCH(diffuse, Bsdf::Diffuse(Rgb(0.5f)));
LODESTAR_BSDF_BENCH(conductor, Bsdf::Conductor(kEta, kK, {0.2f, 0.2f}));
LODESTAR_BSDF_BENCH(conductor_anisotropic, Bsdf::Conductor(kEta, kK, {0.2f, 0.4f}));
LODESTAR_BSDF_BENCH(smooth_conductor, Bsdf::Conductor(kEta, kK, {0, 0}));
LODESTAR_BSDF_BENCH(dielectric, Bsdf::Dielectric(1.5f, {0.2f, 0.2f}));
LODESTAR_BSDF_BENCH(smooth_dielectric, Bsdf::Dielectric(1.5f, {0, 0}));
LODESTAR_BSDF_BENCH(thin_dielectric, Bsdf::ThinDielectric(1.5f));
LODESTAR_BSDF_BENCH(coated_diffuse, Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.1f, 0.1f}));
LODESTAR_BSDF_BENCH(smooth_coated_diffuse, Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0, 0}));
LODESTAR_BSDF_BENCH(coated_conductor, Bsdf::CoatedConductor(1.5f, {0.1f, 0.1f}, kEta, kK, {0.2f, 0.2f}));
LODESTAR_BSDF_BENCH(diffuse_transmission, Bsdf::DiffuseTransmission(Rgb(0.4f), Rgb(0.3f)));

// What a textured material costs at every hit besides.
void MakeCoatedDiffuse(benchmark::State& state) {
  float x = 0.1f;
  for (auto _ : state) {
    Bsdf b = Bsdf::CoatedDiffuse(Rgb(x), 1.5f, {0.1f, 0.1f});
    benchmark::DoNotOptimize(b);
  }
}
BENCHMARK(MakeCoatedDiffuse);
void WithReflectance(benchmark::State& state) {
  Bsdf coated = Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.1f, 0.1f});
  for (auto _ : state) {
    benchmark::DoNotOptimize(coated);
    Bsdf b = coated.WithReflectance(Rgb(0.2f));
    benchmark::DoNotOptimize(b);
  }
}
BENCHMARK(WithReflectance);
// Built once for each eta of a scene.
void BuildCoatTable(benchmark::State& state) {
  float eta = 1.5f;
  for (auto _ : state) benchmark::DoNotOptimize(&CoatTable::For(eta += 1e-3f));
}
BENCHMARK(BuildCoatTable)->Iterations(5)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lodestar
