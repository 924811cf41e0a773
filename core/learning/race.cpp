#include "core/learning/race.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/film/error_metrics.h"

namespace lodestar {
namespace {

constexpr uint32_t kBlocks = 8;  // a side

double Mean(const std::vector<double>& values, size_t without = ~size_t{0}) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    if (i == without) continue;
    sum += values[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

// a's efficiency over b's, one block left out; 1 where both are free of noise.
double Ratio(const PilotResult& a, const PilotResult& b, size_t without = ~size_t{0}) {
  constexpr double kTiny = 1e-30;
  return (Mean(b.variances, without) * b.work + kTiny) / (Mean(a.variances, without) * a.work + kTiny);
}

}  // namespace

PilotResult MeasurePilot(uint32_t candidate, const Film& film, double work, const PixelEstimate& pixels) {
  LODESTAR_CHECK(film.passes() >= 2);
  PilotResult result;
  result.candidate = candidate;
  result.passes = film.passes();
  result.work = work / static_cast<double>(film.passes());
  const Image image = film.Develop();
  const uint32_t columns = std::min(kBlocks, image.width), rows = std::min(kBlocks, image.height);
  std::vector<double> sums(size_t{columns} * rows);
  std::vector<uint32_t> counts(sums.size());
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const double expected = pixels.At(x, y);
      const double value = image.variance[size_t{y} * image.width + x] / (expected * expected + kRelMseEpsilon);
      const size_t block = size_t{y} * rows / image.height * columns + size_t{x} * columns / image.width;
      sums[block] += value;
      ++counts[block];
    }
  }
  for (size_t block = 0; block < sums.size(); ++block)
    result.variances.push_back(sums[block] / std::max(1u, counts[block]) * static_cast<double>(film.passes()));
  return result;
}

EfficiencyRatio CompareEfficiency(const PilotResult& a, const PilotResult& b) {
  LODESTAR_CHECK(a.variances.size() == b.variances.size() && !a.variances.empty());
  const double value = Ratio(a, b);
  const auto n = static_cast<double>(a.variances.size());
  // Efron and Stein 1981: the jackknife's variance.
  double mean = 0, squares = 0;
  std::vector<double> left_out;
  for (size_t i = 0; i < a.variances.size(); ++i) left_out.push_back(Ratio(a, b, i));
  for (const double v : left_out) mean += v / n;
  for (const double v : left_out) squares += (v - mean) * (v - mean);
  const double error = n > 1 ? std::sqrt(squares * (n - 1) / n) : value;
  return {value, std::max(0.0, value - 1.96 * error), value + 1.96 * error};
}

void PilotResult::Write(ByteWriter& out) const {
  out.Put(candidate);
  out.Put(passes);
  out.Put(work);
  out.PutVector(variances);
}

PilotResult PilotResult::Read(ByteReader& in) {
  PilotResult result;
  result.candidate = in.Get<uint32_t>();
  result.passes = in.Get<uint64_t>();
  result.work = in.Get<double>();
  result.variances = in.GetVector<double>();
  if (!(result.work >= 0) || result.variances.empty()) in.Fail("has a pilot result that measures nothing");
  for (const double v : result.variances) {
    if (!(v >= 0)) in.Fail("has a negative variance");
  }
  return result;
}

}  // namespace lodestar
