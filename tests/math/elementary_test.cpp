// The elementary functions against the long double library, over dense ranges; the measured maxima are printed and
// bounded by the header's word.
#include "core/math/elementary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace lodestar {
namespace {

struct Worst {
  double error = 0, at = 0;
  void Add(double e, double x) {
    if (!(e <= error)) error = e, at = x;  // a NaN is worst of all
  }
};

// f(x) against g(x) on n steps from a to b; relative or absolute error.
template <typename F, typename G>
Worst Measure(double a, double b, int n, bool relative, const F& f, const G& g) {
  Worst worst;
  for (int i = 0; i <= n; ++i) {
    const float x = static_cast<float>(a + (b - a) * i / n);
    const long double exact = g(static_cast<long double>(x));
    const double error = static_cast<double>(std::fabs(static_cast<long double>(f(x)) - exact));
    worst.Add(relative ? error / static_cast<double>(std::fabs(exact)) : error, x);
  }
  return worst;
}

constexpr int kSteps = 400000;

TEST(Elementary, SinCos) {
  for (const double range : {4.0, 100.0, 8192.0}) {
    const Worst s = Measure(
        -range, range, kSteps, false, [](float x) { return SinCos(x).sin; }, [](long double x) { return std::sin(x); });
    const Worst c = Measure(
        -range, range, kSteps, false, [](float x) { return SinCos(x).cos; }, [](long double x) { return std::cos(x); });
    std::printf("|x| <= %g: sin %.2e at %g, cos %.2e at %g\n", range, s.error, s.at, c.error, c.at);
    EXPECT_LT(s.error, 2e-7);
    EXPECT_LT(c.error, 2e-7);
  }
  EXPECT_EQ(SinCos(0).sin, 0);
  EXPECT_EQ(SinCos(0).cos, 1);
}

TEST(Elementary, Exp) {
  const Worst w = Measure(
      -87, 88.5, kSteps, true, [](float x) { return Exp(x); }, [](long double x) { return std::exp(x); });
  std::printf("exp: relative %.2e at %g\n", w.error, w.at);
  EXPECT_LT(w.error, 2e-7);
  EXPECT_EQ(Exp(0), 1);
  EXPECT_EQ(Exp(-100), 0);
  EXPECT_EQ(Exp(-kInfinity), 0);
  EXPECT_EQ(Exp(100), kInfinity);
  EXPECT_TRUE(std::isnan(Exp(std::numeric_limits<float>::quiet_NaN())));
}

TEST(Elementary, Log) {
  // Relative away from 1, where the result goes through zero; absolute around it.
  const auto f = [](float x) { return Log(x); };
  const auto g = [](long double x) { return std::log(x); };
  const Worst small = Measure(1e-6, 0.7, kSteps, true, f, g), large = Measure(1.5, 1e6, kSteps, true, f, g);
  const Worst middle = Measure(0.5, 2, kSteps, false, f, g);
  std::printf("log: relative %.2e at %g, %.2e at %g; absolute %.2e at %g\n", small.error, small.at, large.error,
              large.at, middle.error, middle.at);
  EXPECT_LT(small.error, 2e-7);
  EXPECT_LT(large.error, 2e-7);
  EXPECT_LT(middle.error, 1e-7);
  for (float x = 1e-38f; x < 1e38f; x *= 1.7f)
    EXPECT_NEAR(Log(x), std::log(x), 2e-7 * std::fabs(std::log(x)) + 1e-7) << x;
  EXPECT_EQ(Log(1), 0);
  EXPECT_EQ(Log(0), -kInfinity);
  EXPECT_EQ(Log(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(Log(-1)));
}

TEST(Elementary, Pow) {
  // exp(y log x): the error of the logarithm is multiplied by y log x.
  for (const float y : {0.5f, 2.4f, 1 / 2.4f, 5.0f}) {
    const Worst w = Measure(
        1e-3, 10, kSteps / 4, true, [y](float x) { return Pow(x, y); },
        [y](long double x) { return std::pow(x, static_cast<long double>(y)); });
    std::printf("pow(x, %g): relative %.2e at %g\n", static_cast<double>(y), w.error, w.at);
    EXPECT_LT(w.error, 5e-7 * (1 + 7 * y));
  }
  EXPECT_EQ(Pow(0, 2), 0);
  EXPECT_EQ(Pow(3, 0), 1);
  EXPECT_EQ(Pow(0, 0), 1);
  EXPECT_EQ(Pow(0, -1), kInfinity);
}

TEST(Elementary, Atan2) {
  Worst worst;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = -M_PI + 2 * M_PI * i / kSteps;
    for (const double r : {1e-6, 1.0, 1e6}) {
      const float y = static_cast<float>(r * std::sin(angle)), x = static_cast<float>(r * std::cos(angle));
      const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
      worst.Add(static_cast<double>(std::fabs(static_cast<long double>(Atan2(y, x)) - exact)), angle);
    }
  }
  std::printf("atan2: absolute %.2e at %g\n", worst.error, worst.at);
  EXPECT_LT(worst.error, 3e-7);
  EXPECT_EQ(Atan2(0, 1), 0);
  EXPECT_FLOAT_EQ(Atan2(0, -1), kPi);
  EXPECT_FLOAT_EQ(Atan2(-0.0f, -1), -kPi);
  EXPECT_EQ(Atan2(0, 0), 0);
  EXPECT_FLOAT_EQ(Atan2(0, -0.0f), kPi);
  EXPECT_FLOAT_EQ(Atan2(2, 0), kPi / 2);
}

TEST(Elementary, AcosAsin) {
  const Worst c = Measure(
      -1, 1, kSteps, false, [](float x) { return Acos(x); }, [](long double x) { return std::acos(x); });
  const Worst s = Measure(
      -1, 1, kSteps, false, [](float x) { return Asin(x); }, [](long double x) { return std::asin(x); });
  std::printf("acos %.2e at %g, asin %.2e at %g\n", c.error, c.at, s.error, s.at);
  EXPECT_LT(c.error, 3e-7);
  EXPECT_LT(s.error, 3e-7);
  EXPECT_EQ(Acos(1.5f), 0);
  EXPECT_FLOAT_EQ(Acos(-1.5f), kPi);
}

TEST(Elementary, Tan) {
  const Worst w = Measure(
      -1.4, 1.4, kSteps, true, [](float x) { return x == 0 ? 1 : Tan(x); },
      [](long double x) { return x == 0 ? 1 : std::tan(x); });
  std::printf("tan: relative %.2e at %g\n", w.error, w.at);
  EXPECT_LT(w.error, 1e-6);
}

}  // namespace
}  // namespace lodestar
