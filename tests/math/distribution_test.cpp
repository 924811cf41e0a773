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

TEST(PiecewiseConstant1D, InvertsItsOwnDensity) {
  const std::vector<float> values{0, 1, 4, 0, 0.25f, 2, 0};
  const PiecewiseConstant1D d(values);
  EXPECT_NEAR(d.integral(), 7.25 / 7, 1e-7);
  double previous = -1, sum = 0;
  for (int i = 0; i < 7000; ++i) sum += d.Pdf((i + 0.5f) / 7000) / 7000;
  EXPECT_NEAR(sum, 1, 1e-6);
  for (int i = 0; i < 4096; ++i) {
    const auto s = d.Sample(i / 4096.0f);
    EXPECT_GE(s.x, previous);  // monotone
    previous = s.x;
    EXPECT_GT(s.pdf, 0);
    EXPECT_EQ(d.Pdf(s.x), s.pdf);
  }
  EXPECT_GT(d.Sample(kOneMinusEpsilon).pdf, 0);
}

TEST(PiecewiseConstant1D, UniformWhereAllIsZero) {
  const PiecewiseConstant1D d(std::vector<float>(5, 0.0f));
  EXPECT_FLOAT_EQ(d.Sample(0.3f).x, 0.3f);
  EXPECT_EQ(d.Sample(0.3f).pdf, 1);
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
  EXPECT_NEAR(d.integral(), total / values.size(), 1e-4);
  constexpr int kSamples = 500000;
  std::vector<int> counts(values.size());
  for (int i = 0; i < kSamples; ++i) {
    const auto s = d.Sample({Uniform(i, 2), Uniform(i, 3)});
    ASSERT_GT(s.pdf, 0);
    ASSERT_EQ(s.pdf, d.Pdf(s.p));
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
