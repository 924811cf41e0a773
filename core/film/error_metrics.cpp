#include "core/film/error_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

// Indices of the largest values, ties by index, so that the cut does not depend on a library's selection algorithm.
std::vector<bool> Worst(const std::vector<double>& values, size_t count) {
  std::vector<uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto worse = [&](uint32_t a, uint32_t b) { return values[a] != values[b] ? values[a] > values[b] : a < b; };
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(), worse);
  std::vector<bool> worst(values.size());
  for (size_t i = 0; i < count; ++i) worst[order[i]] = true;
  return worst;
}

double Mean(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// That share of the pixels, rounded down: of reports' images below 1000 pixels have none left out.
size_t TrimmedCount(const std::vector<double>& values, double left_out) {
  return static_cast<size_t>(static_cast<double>(values.size()) * left_out);
}

// Mean without those.
double TrimmedMean(const std::vector<double>& values) {
  const size_t cut = TrimmedCount(values, kTrimmedFraction);
  if (cut == 0) return Mean(values);
  const std::vector<bool> worst = Worst(values, cut);
  double sum = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    if (!worst[i]) sum += values[i];
  }
  return sum / static_cast<double>(values.size() - cut);
}

void CheckComparable(const Image& image, const Image& reference) {
  if (image.width != reference.width || image.height != reference.height) {
    throw Error(ErrorKind::kInvalidInput, "the image is " + std::to_string(image.width) + "x" +
                                              std::to_string(image.height) + " and the reference " +
                                              std::to_string(reference.width) + "x" + std::to_string(reference.height) +
                                              " pixels; render with --resolution of the reference");
  }
  const auto check = [](const Image& which, const char* name) {
    LODESTAR_CHECK(which.pixels.size() == size_t{which.width} * which.height);
    for (size_t i = 0; i < which.pixels.size(); ++i) {
      if (!IsFinite(which.pixels[i])) {
        throw Error(ErrorKind::kInvalidInput, std::string("the ") + name + " has a pixel that is not finite at x " +
                                                  std::to_string(i % which.width) + ", y " +
                                                  std::to_string(i / which.width) +
                                                  "; errors against it have no meaning");
      }
    }
  };
  check(image, "image");
  check(reference, "reference");
}

// Luminance averaged over each pixel's 3x3 neighbourhood (less at the border), rows first.
std::vector<double> SmoothedLuminance(const Image& image) {
  const size_t w = image.width, h = image.height;
  std::vector<double> rows(w * h), smoothed(w * h);
  for (size_t y = 0; y < h; ++y) {
    for (size_t x = 0; x < w; ++x) {
      double sum = 0;
      const size_t first = x > 0 ? x - 1 : 0, last = std::min(x + 1, w - 1);
      for (size_t u = first; u <= last; ++u) sum += Luminance(image.pixels[y * w + u]);
      rows[y * w + x] = sum / static_cast<double>(last - first + 1);
    }
  }
  for (size_t y = 0; y < h; ++y) {
    const size_t first = y > 0 ? y - 1 : 0, last = std::min(y + 1, h - 1);
    for (size_t x = 0; x < w; ++x) {
      double sum = 0;
      for (size_t v = first; v <= last; ++v) sum += rows[v * w + x];
      smoothed[y * w + x] = sum / static_cast<double>(last - first + 1);
    }
  }
  return smoothed;
}

}  // namespace

double RelativeEpsilon(double mean_luminance) {
  return kRelMseEpsilon * (mean_luminance > 0 ? mean_luminance * mean_luminance : 1);
}

ErrorMetrics Compare(const Image& image, const Image& reference) {
  CheckComparable(image, reference);
  ErrorMetrics metrics;
  std::vector<double> relative(image.pixels.size());
  double squares = 0, absolutes = 0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double x = image.pixels[i][c], r = reference.pixels[i][c], d = x - r;
      squares += d * d;
      absolutes += std::fabs(d);
      relative[i] += d * d / (r * r + kRelMseEpsilon) / 3;
    }
  }
  const double values = std::max<double>(1, 3.0 * static_cast<double>(image.pixels.size()));
  metrics.mse = squares / values;
  metrics.rmse = std::sqrt(metrics.mse);
  metrics.mae = absolutes / values;
  metrics.relmse = Mean(relative);
  metrics.relmse_trimmed = TrimmedMean(relative);
  return metrics;
}

EstimatedError EstimateError(const Image& image) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (image.pixels.empty() || image.variance.size() != image.pixels.size()) return {kUnknown, kUnknown};
  const std::vector<double> luminance = SmoothedLuminance(image);
  std::vector<double> relative(image.pixels.size());
  for (size_t i = 0; i < relative.size(); ++i)
    relative[i] = image.variance[i] / (luminance[i] * luminance[i] + kRelMseEpsilon);
  const double mean = Mean(luminance);
  return {Mean(relative), TrimmedVariance(image, relative, mean * mean + kRelMseEpsilon)};
}

double TrimmedVariance(const Image& image, const std::vector<double>& relative, double square, double left_out) {
  constexpr double kOutliersLight = 0.25;
  const size_t cut = TrimmedCount(relative, left_out);
  if (cut == 0) return Mean(relative);
  const std::vector<bool> worst = Worst(relative, cut);
  double kept = 0, outliers = 0, kept_light = 0, outliers_light = 0;
  for (size_t i = 0; i < relative.size(); ++i) {
    (worst[i] ? outliers : kept) += worst[i] ? image.variance[i] / square : relative[i];
    (worst[i] ? outliers_light : kept_light) += Luminance(image.pixels[i]);
  }
  if (outliers_light > kOutliersLight * (kept_light + outliers_light))
    return (kept + outliers) / static_cast<double>(relative.size());
  return kept / static_cast<double>(relative.size() - cut);
}

double LargestKept(std::vector<double> values, double left_out) {
  const auto last = values.end() - static_cast<std::ptrdiff_t>(TrimmedCount(values, left_out) + 1);
  std::nth_element(values.begin(), last, values.end());
  return *last;
}

std::vector<float> RelativeLuminanceError(const Image& image, const Image& reference) {
  CheckComparable(image, reference);
  std::vector<float> error(image.pixels.size());
  for (size_t i = 0; i < error.size(); ++i) {
    const double x = Luminance(image.pixels[i]), r = Luminance(reference.pixels[i]);
    error[i] = static_cast<float>((x - r) / (std::max(r, 0.0) + kRelMseEpsilon));
  }
  return error;
}

}  // namespace lodestar
