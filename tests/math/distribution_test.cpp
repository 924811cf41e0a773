#include "core/math/distribution.h"

#include <gtest/gtest.h>

#include <map>

#include "core/math/sampler.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

float Uniform(uint32_t i, uint32_t stream) {
  return Sampler::ToUnit(static_cast<uint32_t>(Mix64((uint64_t{stream} << 32) | i) >> 32));
}

TEST(AliasTable, PicksByWeight) {
  constexpr int kSamples = 400000;
  const std::vector<double> weights{3, 0, 1, 0.5, 10, 0, 0.01, 2};
  const AliasTable table(weights);
  std::vector<double> observed(weights.size()), expected(weights.size());
  for (int i = 0; i < kSamples; ++i) ++observed[table.Sample(Uniform(i, 1))];
  for (size_t i = 0; i < weights.size(); ++i) {
    EXPECT_NEAR(table.Pmf(uint32_t(i)), weights[i] / 16.51, 1e-7);
    expected[i] = weights[i] / 16.51 * kSamples;
  }
  const test::TestResult r = test::ChiSquareTest(observed, expected, 1e-3);
  EXPECT_TRUE(r.accepted) << r.message;
  // Two per cent of a weight moved to its neighbour are seen, and so is any sample where there is no weight.
  std::vector<double> wrong = expected;
  wrong[4] -= 0.02 * expected[4];
  wrong[7] += 0.02 * expected[4];
  EXPECT_FALSE(test::ChiSquareTest(observed, wrong, 1e-3).accepted);
  wrong = expected;
  std::swap(wrong[5], wrong[6]);
  EXPECT_FALSE(test::ChiSquareTest(observed, wrong, 1e-3).accepted);
}

TEST(AliasTable, TinyWeightsKeepTheirProbability) {
  const AliasTable table(std::vector<double>{1e-12, 1, 1e12});
  EXPECT_GT(table.Pmf(0), 0);
  EXPECT_FLOAT_EQ(table.Pmf(1), 1e-12f);
  EXPECT_EQ(AliasTable(std::vector<double>{0, 0, 5}).Sample(0.1f), 2u);
}

// How far off are the picks of every u below `q`, stretched by 1 / q as where a choice comes before: the worst share of
// a class of indices, against its probability. A class is those that as many of the u pick; small ones are left out.
struct PickErrors {
  double plain = 0, refined = 0;
};
PickErrors WorstErrors(const std::vector<double>& weights, float q) {
  const AliasTable table(weights);
  std::vector<Sampler> samplers;  // about as many numbers for each q
  for (uint32_t pass = 0; pass < 1 / q; ++pass) samplers.emplace_back(1, 2, 3, pass);
  std::vector<uint32_t> plain(weights.size()), refined(weights.size());
  for (uint32_t k = 0; k < 1u << 24; ++k) {
    const float u = static_cast<float>(k) * 0x1p-24f;
    if (!(u < q)) break;
    ++plain[table.Sample(double{u} / q)];
    for (const Sampler& sampler : samplers) {
      const double fine = sampler.Refine(u);
      if (fine < q) ++refined[table.Sample(fine / q)];
    }
  }
  struct Class {
    double plain = 0, refined = 0, expected = 0;
  };
  std::map<uint32_t, Class> classes;
  for (uint32_t i = 0; i < weights.size(); ++i) {
    Class& c = classes[plain[i]];
    c.plain += plain[i] / (0x1p24 * q);
    c.refined += refined[i] / (0x1p24 * q * double(samplers.size()));
    c.expected += table.Pmf(i);
  }
  PickErrors worst;
  for (const auto& [count, c] : classes) {
    if (c.expected < 0.1) continue;
    worst.plain = std::max(worst.plain, std::fabs(c.plain / c.expected - 1));
    worst.refined = std::max(worst.refined, std::fabs(c.refined / c.expected - 1));
  }
  return worst;
}

TEST(AliasTable, PicksByWeightAmongMany) {
  std::vector<double> equal(1000000, 1.0), unequal(1 << 20, 1.0);
  for (size_t i = 0; i < unequal.size(); i += 2) unequal[i] = 0.3;
  for (const std::vector<double>* weights : {&equal, &unequal})
    for (const float q : {1.0f, 0.1f}) {
      const PickErrors errors = WorstErrors(*weights, q);
      EXPECT_LT(errors.refined, 1e-3) << weights->size() << " weights, q " << q;
      EXPECT_GT(errors.plain, 0.04) << weights->size() << " weights, q " << q;  // what 24 bits do
    }
}

// Interleaved with something else, as its users have it.
struct Cdf {
  using Guided = GuidedCdf<3>;
  explicit Cdf(const std::vector<float>& values)
      : cells(static_cast<uint32_t>(values.size())), ends(3 * values.size()), guide(Guided::Slots(cells)) {
    sum = Guided::Build(values, ends.data(), guide.data());
  }
  uint32_t Find(float u) const { return Guided::Find(ends.data(), guide.data(), cells, u); }
  float Position(float u) const { return Guided::Position(ends.data(), Find(u), cells, u); }
  float Start(uint32_t cell) const { return cell > 0 ? ends[3 * (cell - 1)] : 0; }
  float End(uint32_t cell) const { return ends[3 * cell]; }
  uint32_t cells;
  double sum;
  std::vector<float> ends;
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
    for (uint32_t i = 0; i < cells; ++i) {
      const float edge = d.End(i);
      for (const float u : {edge, std::nextafter(edge, 0.0f), std::nextafter(edge, 1.0f)}) {
        if (u < 1) probes.push_back(u);
      }
    }
    for (const float u : probes) {
      const uint32_t cell = d.Find(u);
      ASSERT_LE(d.Start(cell), u);
      ASSERT_GT(d.End(cell), u);
      // Within the cell, but for the rounding of its own edge where the number of cells is not a power of two.
      const float scaled = d.Position(u) * static_cast<float>(cells), slack = 2e-7f * static_cast<float>(cells);
      ASSERT_GE(scaled, static_cast<float>(cell) - slack) << cells << " cells, u " << u;
      ASSERT_LT(scaled, static_cast<float>(cell + 1)) << cells << " cells, u " << u;
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
    EXPECT_NEAR(d.Start(d.Find(u)) + (d.Position(u) * 7 - d.Find(u)) * values[d.Find(u)] / 7.25, u, 1e-6);
  }
  EXPECT_EQ(d.Find(kOneMinusEpsilon), 5u);
}

TEST(GuidedCdf, UniformWhereAllIsZero) {
  EXPECT_FLOAT_EQ(Cdf(std::vector<float>(5, 0.0f)).Position(0.3f), 0.3f);
}

}  // namespace
}  // namespace lodestar
