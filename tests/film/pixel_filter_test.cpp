#include "core/film/pixel_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/sampler.h"

namespace lodestar {
namespace {

using Kind = PixelFilter::Kind;

Vec2 Uniform(uint32_t i) {
  const uint64_t bits = Mix64(i + 77);
  return {Sampler::ToUnit(uint32_t(bits >> 32)), Sampler::ToUnit(uint32_t(bits))};
}

// How far weighted samples are from being distributed as the filter f, in the moments that an image sees (mean 0,
// second moments) and a histogram of one axis: the largest difference, as a multiple of what chance and the bins allow.
double Misfit(const PixelFilter& filter, const PixelFilter::Parameters& f) {
  constexpr int kBins = 24, kGrid = 960, kSamples = 1000000;
  std::vector<double> mass(kBins), absolute_mass(kBins);
  double total = 0, second = 0, absolute = 0;
  for (int i = 0; i < kGrid; ++i) {
    const float x = ((i + 0.5f) / kGrid * 2 - 1) * f.radius_x;
    const double v = PixelFilter::Evaluate(f, {x, 0});
    mass[i * kBins / kGrid] += v;
    absolute_mass[i * kBins / kGrid] += std::fabs(v);
    total += v;
    absolute += std::fabs(v);
    second += v * x * x;
  }
  second /= total;
  std::vector<double> histogram(kBins);
  double mean_weight = 0, mean_x = 0, mean_xx = 0;
  for (int i = 0; i < kSamples; ++i) {
    const FilterSample s = filter.Sample(Uniform(i));
    EXPECT_LE(std::fabs(s.offset.x), f.radius_x);
    EXPECT_LE(std::fabs(s.offset.y), f.radius_y);
    mean_weight += s.weight;
    mean_x += s.weight * s.offset.x;
    mean_xx += s.weight * s.offset.x * s.offset.x;
    histogram[std::min(kBins - 1, int((s.offset.x / f.radius_x + 1) / 2 * kBins))] += s.weight;
  }
  const double w = Sqr(float(absolute / total));  // the size of every weight
  const double sigma = w / std::sqrt(double(kSamples));
  double worst = 0;
  const auto compare = [&](double sum, double expected, double tolerance) {
    worst = std::max(worst, std::fabs(sum / kSamples - expected) / tolerance);
  };
  compare(mean_weight, 1, 5 * sigma + 1e-4);
  compare(mean_x, 0, 5 * sigma * f.radius_x);
  compare(mean_xx, second, 5 * sigma * f.radius_x * f.radius_x + 1e-4);
  for (int b = 0; b < kBins; ++b)
    compare(histogram[b], mass[b] / total, 5 * sigma * std::sqrt(absolute_mass[b] / absolute) + 1e-4);
  return worst;
}

class PixelFilterTest : public testing::TestWithParam<PixelFilter::Parameters> {};

TEST_P(PixelFilterTest, SamplesReproduceTheFilter) {
  EXPECT_LE(Misfit(PixelFilter(GetParam()), GetParam()), 1);
}

INSTANTIATE_TEST_SUITE_P(
    All, PixelFilterTest,
    testing::Values(PixelFilter::Parameters{.kind = Kind::kBox},
                    PixelFilter::Parameters{.kind = Kind::kBox, .radius_x = 1.5f, .radius_y = 2},
                    PixelFilter::Parameters{.kind = Kind::kTriangle, .radius_x = 2, .radius_y = 1},
                    PixelFilter::Parameters{.kind = Kind::kGaussian, .radius_x = 1.5f, .radius_y = 1.5f},
                    PixelFilter::Parameters{.kind = Kind::kMitchell, .radius_x = 2, .radius_y = 2}));

TEST(PixelFilter, SamplesOfAnotherFilterAreSeen) {
  const PixelFilter::Parameters gaussian{.kind = Kind::kGaussian, .radius_x = 1.5f, .radius_y = 1.5f, .sigma = 0.5f};
  PixelFilter::Parameters wider = gaussian;
  wider.sigma = 0.51f;
  EXPECT_GT(Misfit(PixelFilter(gaussian), wider), 1);
  const PixelFilter::Parameters mitchell{.kind = Kind::kMitchell, .radius_x = 2, .radius_y = 2};
  PixelFilter::Parameters sharper = mitchell;
  sharper.c = 0.35f;
  EXPECT_GT(Misfit(PixelFilter(mitchell), sharper), 1);
  EXPECT_GT(Misfit(PixelFilter({.kind = Kind::kBox, .radius_x = 1.5f, .radius_y = 1.5f}),
                   {.kind = Kind::kBox, .radius_x = 1.51f, .radius_y = 1.5f}),
            1);
}

TEST(PixelFilter, KnownValues) {
  EXPECT_FLOAT_EQ(PixelFilter::Evaluate({.kind = Kind::kTriangle, .radius_x = 2, .radius_y = 2}, {0.5f, -1}), 1.5f);
  // Mitchell with B = C = 1/3: 8/9 in the middle, 1/18 at half the radius, negative beyond.
  const PixelFilter::Parameters mitchell{.kind = Kind::kMitchell, .radius_x = 2, .radius_y = 2};
  EXPECT_NEAR(PixelFilter::Evaluate(mitchell, {0, 0}), 64 / 81.0, 1e-6);
  EXPECT_NEAR(PixelFilter::Evaluate(mitchell, {1, 0}), 8 / 9.0 / 18, 1e-6);
  EXPECT_LT(PixelFilter::Evaluate(mitchell, {1.5f, 0}), 0);
  // The Gaussian ends at zero.
  const PixelFilter::Parameters gaussian{.kind = Kind::kGaussian, .radius_x = 1.5f, .radius_y = 1.5f, .sigma = 0.5f};
  EXPECT_NEAR(PixelFilter::Evaluate(gaussian, {1.4999f, 0}), 0, 1e-4);
  EXPECT_NEAR(PixelFilter::Evaluate(gaussian, {0, 0}), Sqr(0.7978846f - 0.0088637f), 1e-5);
}

TEST(PixelFilter, GaussiansOfAnyWidthAreWeighted) {
  struct Limit {
    float sigma;
    double second_moment;  // of one axis, in squares of the radius
  };
  // Of a parabola, and of a point in the middle.
  for (const auto& [sigma, second_moment] :
       {Limit{1e4f, 0.2}, Limit{1e30f, 0.2}, Limit{1e-3f, 0}, Limit{1e-5f, 0}, Limit{1e-30f, 0}}) {
    const PixelFilter::Parameters f{.kind = Kind::kGaussian, .radius_x = 1.5f, .radius_y = 2, .sigma = sigma};
    const PixelFilter filter(f);
    constexpr int kSamples = 100000;
    double weight = 0, xx = 0, yy = 0;
    for (int i = 0; i < kSamples; ++i) {
      const FilterSample s = filter.Sample(Uniform(i));
      ASSERT_TRUE(std::isfinite(s.weight)) << sigma;
      weight += s.weight / kSamples;
      xx += s.weight * Sqr(s.offset.x / f.radius_x) / kSamples;
      yy += s.weight * Sqr(s.offset.y / f.radius_y) / kSamples;
    }
    EXPECT_NEAR(weight, 1, 1e-3) << sigma;
    EXPECT_NEAR(xx, second_moment, 5e-3) << sigma;
    EXPECT_NEAR(yy, second_moment, 5e-3) << sigma;
  }
}

TEST(PixelFilter, NegativeLobesCarryTheirSign) {
  const PixelFilter filter({.kind = Kind::kMitchell, .radius_x = 2, .radius_y = 2});
  int negative = 0;
  for (int i = 0; i < 20000; ++i) negative += filter.Sample(Uniform(i)).weight < 0;
  EXPECT_GT(negative, 100);
}

}  // namespace
}  // namespace lodestar
