#include "core/math/distribution.h"

#include <gtest/gtest.h>

#include "core/math/sampler.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

float Uniform(uint32_t i, uint32_t stream) {
  return Sampler::ToUnit(static_cast<uint32_t>(Mix64((uint64_t{stream} << 32) | i) >> 32));
}

TEST(AliasTable, PicksByWeight) {
  const std::vector<double> weights{3, 0, 1, 0.5, 10, 0, 0.01, 2};
  const AliasTable table(weights);
  const double total = 16.51;
  constexpr int kSamples = 400000;
  std::vector<int> counts(weights.size());
  for (int i = 0; i < kSamples; ++i) ++counts[table.Sample(Uniform(i, 1))];
  double statistic = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    EXPECT_NEAR(table.Pmf(uint32_t(i)), weights[i] / total, 1e-7);
    if (weights[i] == 0) {
      EXPECT_EQ(counts[i], 0);
    } else {
      const double expected = weights[i] / total * kSamples;
      statistic += Sqr(float(counts[i] - expected)) / expected;
    }
  }
  EXPECT_LT(statistic, 22.5);  // chi-square of 5 degrees of freedom, 0.9996
}

TEST(AliasTable, TinyWeightsKeepTheirProbability) {
  const AliasTable table(std::vector<double>{1e-12, 1, 1e12});
  EXPECT_GT(table.Pmf(0), 0);
  EXPECT_FLOAT_EQ(table.Pmf(1), 1e-12f);
  EXPECT_EQ(AliasTable(std::vector<double>{0, 0, 5}).Sample(0.1f), 2u);
}

struct Cdf {
  explicit Cdf(const std::vector<float>& values)
      : cells(static_cast<uint32_t>(values.size())), cdf(values.size() + 1), guide(values.size()) {
    sum = GuidedCdf::Build(values, cdf.data(), guide.data());
  }
  uint32_t Find(float u) const { return GuidedCdf::Find(cdf.data(), guide.data(), cells, u); }
  float Position(float u) const { return GuidedCdf::Position(cdf.data(), Find(u), cells, u); }
  uint32_t cells;
  double sum;
  std::vector<float> cdf;
  std::vector<uint16_t> guide;
};

TEST(GuidedCdf, FindsTheCellThatHoldsU) {
  for (const uint32_t cells : {1u, 2u, 7u, 64u, 1000u}) {
    std::vector<float> values(cells);
    for (uint32_t i = 0; i < cells; ++i) {
      const float x = Uniform(i, 7);
      values[i] = x < 0.3f ? 0 : x > 0.95f ? 1000 * x : x * x;
    }
    const Cdf d(values);
    std::vector<float> probes{0, kOneMinusEpsilon};
    for (uint32_t i = 0; i < 4096; ++i) probes.push_back(Uniform(i, 8));
    for (const float edge : d.cdf) {
      for (const float u : {edge, std::nextafter(edge, 0.0f), std::nextafter(edge, 1.0f)}) {
        if (u < 1) probes.push_back(u);
      }
    }
    for (const float u : probes) {
      const uint32_t cell = d.Find(u);
      ASSERT_LE(d.cdf[cell], u);
      ASSERT_GT(d.cdf[cell + 1], u);
      ASSERT_EQ(static_cast<uint32_t>(d.Position(u) * static_cast<float>(cells)), cell) << cells << " cells, u " << u;
    }
  }
}

TEST(GuidedCdf, InvertsItsOwnDensity) {
  const std::vector<float> values{0, 1, 4, 0, 0.25f, 2, 0};
  const Cdf d(values);
  EXPECT_NEAR(d.sum, 7.25, 1e-6);
  double previous = -1;
  for (int i = 0; i < 4096; ++i) {
    const float u = static_cast<float>(i) / 4096;
    EXPECT_GE(d.Position(u), previous);  // monotone
    previous = d.Position(u);
    EXPECT_GT(values[d.Find(u)], 0);
    EXPECT_NEAR(d.cdf[d.Find(u)] + (d.Position(u) * 7 - d.Find(u)) * values[d.Find(u)] / 7.25, u, 1e-6);
  }
  EXPECT_EQ(d.Find(kOneMinusEpsilon), 5u);
}

TEST(GuidedCdf, UniformWhereAllIsZero) {
  EXPECT_FLOAT_EQ(Cdf(std::vector<float>(5, 0.0f)).Position(0.3f), 0.3f);
}

TEST(PiecewiseConstant2D, CellsAreHitInProportion) {
  // One cell a million times brighter than the rest, which still sum to a twentieth.
  const uint32_t w = 16, h = 8;
  std::vector<float> values(w * h);
  for (size_t i = 0; i < values.size(); ++i) values[i] = i % 5 == 0 ? 0.0f : 1.0f + i % 3;
  values[37] = 4000;
  const PiecewiseConstant2D d(values, w, h);
  double total = 0;
  for (const float v : values) total += v;
  EXPECT_NEAR(d.mean(), total / values.size(), 1e-4);
  constexpr int kSamples = 500000;
  std::vector<int> counts(values.size());
  for (int i = 0; i < kSamples; ++i) {
    const auto s = d.Sample({Uniform(i, 2), Uniform(i, 3)});
    ASSERT_GT(values[s.cell_y * w + s.cell_x], 0);
    ASSERT_EQ(static_cast<uint32_t>(s.p.x * w), s.cell_x);
    ASSERT_EQ(static_cast<uint32_t>(s.p.y * h), s.cell_y);
    ++counts[s.cell_y * w + s.cell_x];
  }
  double statistic = 0;
  int cells = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const double expected = values[i] / total * kSamples;
    if (expected < 5) continue;
    statistic += (counts[i] - expected) * (counts[i] - expected) / expected;
    ++cells;
  }
  EXPECT_GT(cells, 100);
  EXPECT_LT(statistic, cells + 4 * std::sqrt(2.0 * cells));
}

}  // namespace
}  // namespace lodestar
