// Statistical tests for samplers and estimators: chi-square over the sphere or any bins, t-tests, the integral of a
// density.
//
// How to use, in a GoogleTest body:
//
//   constexpr double kLevel = SidakLevel(0.01, kTestsInThisFile);   // chance that any of the tests fails although all
//   samplers are right Random random(1); const TestResult r = ChiSquareOnSphere([&](Random& rng) { return
//   std::optional(SquareToSphere(rng.Next2D())); },
//                                          [](Vec3) { return kUniformSpherePdf; }, {.level = kLevel, .seed = 1});
//   EXPECT_TRUE(r.accepted) << r.message;
//
// Seeds are fixed: a test that passes once passes always. Show once per file that a wrong density is rejected
// (EXPECT_FALSE(r.accepted)). Levels are per test; SidakLevel divides a file's overall level among its tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/math/vec.h"

namespace lodestar::test {

// The significance of one of `count` independent tests such that all of them together reject by chance with probability
// `overall` (Sidak 1967): 1 - (1 - overall)^(1 / count).
inline double SidakLevel(double overall, int count) {
  return -std::expm1(std::log1p(-overall) / count);
}

struct TestResult {
  bool accepted = false;
  double p_value = 0;    // probability of a statistic at least as extreme if the hypothesis holds
  double statistic = 0;  // chi-square or t
  double degrees = 0;    // degrees of freedom
  std::string message;   // the numbers, for the assertion's output
};

// SplitMix64 (Steele et al. 2014): test input only, unrelated to the renderer's Sampler.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t Next();
  float Next1D() { return static_cast<float>(Next() >> 40) * 0x1p-24f; }  // [0, 1), 24 bits
  Vec2 Next2D() {
    const float x = Next1D();
    return {x, Next1D()};
  }

 private:
  uint64_t state_;
};

// Running mean and variance (Welford 1962), in double.
class Moments {
 public:
  void Add(double x) {
    ++count_;
    const double delta = x - mean_;
    mean_ += delta / static_cast<double>(count_);
    m2_ += delta * (x - mean_);
  }
  int64_t count() const { return count_; }
  double mean() const { return mean_; }
  double variance() const { return count_ > 1 ? m2_ / static_cast<double>(count_ - 1) : 0; }  // of one sample
  double standard_error() const { return count_ > 0 ? std::sqrt(variance() / static_cast<double>(count_)) : 0; }

 private:
  int64_t count_ = 0;
  double mean_ = 0, m2_ = 0;
};

// Student's t-test of the mean against a known value, two-sided. `bias_allowed`: a deviation of the mean below it is
// never held against the sample (the known error of `expected`). With zero variance the mean must equal `expected` to
// 1e-6 relative (plus bias_allowed).
TestResult TTest(const Moments& sample, double expected, double level, double bias_allowed = 0);

// Welch's t-test: do two samples of unequal variance have the same mean? Two-sided.
TestResult WelchTest(const Moments& a, const Moments& b, double level, double bias_allowed = 0);

// Pearson's chi-square test of counts against expected counts (of the same total, up to rounding). Bins are pooled in
// ascending order of their expectation until each pool expects `min_expected`; counts in a bin with zero expectation
// reject at once.
TestResult ChiSquareTest(std::span<const double> observed, std::span<const double> expected, double level,
                         double min_expected = 5);

// Kolmogorov-Smirnov is not offered: chi-square with bins by inversion does the same work. Uniformity of values in [0,
// 1):
TestResult ChiSquareUniform(std::span<const float> values, int bins, double level);

using SphereSampler = std::function<std::optional<Vec3>(Random&)>;
using SphereDensity = std::function<double(Vec3)>;  // per solid angle, over unit directions

struct SphereTestOptions {
  double level = 1e-3;
  uint64_t seed = 1;
  int64_t samples = 200000;
  int64_t pilot_samples = 20000;  // place the bins
  int bins = 256;                 // rounded down to a power of two
};

// Do the sampler's directions follow the density? Bins adapt to the distribution: a pilot sample splits the (z, phi)
// rectangle at its medians, so that narrow lobes are resolved, then fresh samples are counted against the density
// integrated over each bin.
//
// The density may integrate to less than one: std::nullopt from the sampler (a failed sample, or a delta lobe not under
// test) falls into a bin of its own that expects the rest, so the test covers the normalisation too. More than 1 + 1e-3
// is rejected.
TestResult ChiSquareOnSphere(const SphereSampler& sampler, const SphereDensity& density,
                             const SphereTestOptions& options = {});

// The integral of a function over the sphere, (upper, lower: the hemispheres z > 0 and z < 0), by adaptive
// Gauss-Legendre quadrature in (z, phi); `focus` (optional) is a direction around which to start refining, for narrow
// lobes. Relative error about 1e-4 for lobes wider than 1e-2.
struct SphereIntegral {
  double upper = 0, lower = 0;
  double Total() const { return upper + lower; }
};
SphereIntegral IntegrateSphere(const SphereDensity& f, std::optional<Vec3> focus = std::nullopt,
                               double tolerance = 1e-5);

// ∫ f(x, y) over [x0, x1] x [y0, y1], adaptive; `tolerance` is absolute, for the whole rectangle; `forced_depth` levels
// of quartering happen in any case, against peaks narrower than the first points' distance.
double IntegrateRectangle(const std::function<double(double, double)>& f, double x0, double x1, double y0, double y1,
                          double tolerance, int max_depth = 12, int forced_depth = 0);

}  // namespace lodestar::test
