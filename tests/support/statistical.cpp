#include "tests/support/statistical.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cstdio>
#include <numeric>
#include <vector>

namespace lodestar::test {
namespace {

template <typename... Args>
std::string Format(const char* format, Args... args) {
  char buffer[512];
  std::snprintf(buffer, sizeof(buffer), format, args...);
  return buffer;
}

TestResult StudentResult(double difference, double standard_error, double degrees, double level, double bias_allowed,
                         const std::string& what) {
  TestResult r;
  r.degrees = degrees;
  const double excess = std::max(std::fabs(difference) - bias_allowed, 0.0);
  if (!(standard_error > 0) || !(degrees > 0)) {
    r.p_value = excess <= 1e-6 * std::fabs(difference) + 1e-12 ? 1 : 0;
    r.statistic = excess > 0 ? INFINITY : 0;
  } else {
    r.statistic = excess / standard_error;
    r.p_value = 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(degrees), r.statistic));
  }
  r.accepted = r.p_value >= level;
  r.message = what + Format(" t = %.4g, %.4g degrees, p = %.3g, level %.3g", r.statistic, degrees, r.p_value, level);
  return r;
}

}  // namespace

uint64_t Random::Next() {
  uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

TestResult TTest(const Moments& sample, double expected, double level, double bias_allowed) {
  const std::string what =
      Format("mean %.8g of %lld, standard error %.3g, expected %.8g (allowed bias %.3g);", sample.mean(),
             static_cast<long long>(sample.count()), sample.standard_error(), expected, bias_allowed);
  if (sample.variance() <= 1e-24 * sample.mean() * sample.mean()) bias_allowed += 1e-6 * std::fabs(expected);
  return StudentResult(sample.mean() - expected, sample.standard_error(), static_cast<double>(sample.count() - 1),
                       level, bias_allowed, what);
}

TestResult WelchTest(const Moments& a, const Moments& b, double level, double bias_allowed) {
  const double va = a.variance() / static_cast<double>(a.count()), vb = b.variance() / static_cast<double>(b.count());
  const double sum = va + vb;
  const double degrees =
      sum > 0
          ? sum * sum / (va * va / static_cast<double>(a.count() - 1) + vb * vb / static_cast<double>(b.count() - 1))
          : 0;
  const std::string what =
      Format("means %.8g +- %.3g and %.8g +- %.3g;", a.mean(), std::sqrt(va), b.mean(), std::sqrt(vb));
  if (sum <= 1e-24 * a.mean() * a.mean()) bias_allowed += 1e-6 * std::fabs(a.mean());
  return StudentResult(a.mean() - b.mean(), std::sqrt(sum), degrees, level, bias_allowed, what);
}

TestResult ChiSquareTest(std::span<const double> observed, std::span<const double> expected, double level,
                         double min_expected) {
  std::vector<size_t> order(expected.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });

  TestResult r;
  double pool_observed = 0, pool_expected = 0;
  int cells = 0;
  double worst = 0;
  size_t worst_bin = 0;
  for (size_t n = 0; n < order.size(); ++n) {
    const size_t bin = order[n];
    if (!(expected[bin] > 0) && observed[bin] > 0) {
      r.message = Format("%g observed in bin %zu where none can fall (expected %g)", observed[bin], bin, expected[bin]);
      return r;
    }
    pool_observed += observed[bin];
    pool_expected += expected[bin];
    const bool last = n + 1 == order.size();
    if (pool_expected < min_expected && !last) continue;
    if (pool_expected <= 0) continue;
    const double term = (pool_observed - pool_expected) * (pool_observed - pool_expected) / pool_expected;
    r.statistic += term;
    ++cells;
    if (term > worst) worst = term, worst_bin = bin;
    pool_observed = pool_expected = 0;
  }
  r.degrees = cells - 1;
  r.p_value =
      r.degrees < 1 ? 1 : boost::math::cdf(boost::math::complement(boost::math::chi_squared(r.degrees), r.statistic));
  r.accepted = r.p_value >= level;
  r.message = Format("chi-square %.4g, %g degrees, p = %.3g, level %.3g; worst bin %zu: observed %.6g, expected %.6g",
                     r.statistic, r.degrees, r.p_value, level, worst_bin, observed.empty() ? 0.0 : observed[worst_bin],
                     expected.empty() ? 0.0 : expected[worst_bin]);
  return r;
}

TestResult ChiSquareUniform(std::span<const float> values, int bins, double level) {
  std::vector<double> observed(bins, 0.0), expected(bins, static_cast<double>(values.size()) / bins);
  for (float v : values) {
    if (!(v >= 0 && v < 1)) return {.message = Format("value %g outside [0, 1)", static_cast<double>(v))};
    ++observed[std::min(static_cast<int>(v * static_cast<float>(bins)), bins - 1)];
  }
  return ChiSquareTest(observed, expected, level);
}

}  // namespace lodestar::test
