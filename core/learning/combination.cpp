#include "core/learning/combination.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/film/error_metrics.h"
#include "core/film/pixel_estimate.h"

namespace lodestar {
namespace {

using Kind = Method::Combination::Kind;

// Variance of a pass relative to what the pixels are expected to have, mean over the pixels; the worst left out, as in
// reports, unless they hold more than kOutliersLight of the film's light: then they are not outliers but what there is,
// and relative to the mean of all pixels, since what is expected of them is mostly themselves.
double VarianceOfAPass(const Film& film, const PixelEstimate& expected) {
  constexpr double kOutliersLight = 0.25;
  if (film.passes() < 2) return std::numeric_limits<double>::infinity();
  const Image image = film.Develop();
  std::vector<double> relative(image.size());
  for (size_t i = 0; i < image.size(); ++i) {
    const double mean = expected.luminance[i];
    relative[i] = image.variance[i] / (mean * mean + kRelMseEpsilon);
  }
  const double most = LargestKept(relative, kTrimmedFraction);
  double kept = 0, outliers = 0, kept_light = 0, outliers_light = 0, mean = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    const bool outlier = relative[i] > most;
    if (outlier) {
      outliers += image.variance[i];
    } else {
      kept += relative[i];
    }
    (outlier ? outliers_light : kept_light) += Luminance(image.pixels[i]);
    mean += expected.luminance[i] / static_cast<double>(image.size());
  }
  outliers /= mean * mean + kRelMseEpsilon;
  const bool trimmed = outliers_light <= kOutliersLight * (kept_light + outliers_light);
  return (trimmed ? kept : kept + outliers) / static_cast<double>(image.size()) * static_cast<double>(film.passes());
}

std::vector<double> InverseVarianceWeights(std::span<const IterationFilm> films) {
  // What each pixel is expected to have: all passes count alike.
  std::vector<double> by_passes;
  uint64_t passes = 0;
  for (const auto& [iteration, film] : films) passes += film.passes();
  if (passes == 0) return std::vector<double>(films.size());
  for (const auto& [iteration, film] : films)
    by_passes.push_back(static_cast<double>(film.passes()) / static_cast<double>(passes));
  if (std::ranges::find(by_passes, 1.0) != by_passes.end()) return by_passes;
  const PixelEstimate expected = EstimatePixels(Combine(films, by_passes));

  std::vector<double> per_pass;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [iteration, film] : films) {
    const double v = VarianceOfAPass(film, expected);
    per_pass.push_back(v);
    if (v > 0) best = std::min(best, v);
  }
  const bool all_unknown = std::none_of(per_pass.begin(), per_pass.end(), [](double v) { return std::isfinite(v); });
  if (!std::isfinite(best)) best = 1;  // nothing varies: passes alone count
  std::vector<double> weights;
  for (size_t i = 0; i < films.size(); ++i) {
    const double v = all_unknown ? 1 : per_pass[i] == 0 ? best : per_pass[i];
    weights.push_back(std::isfinite(v) ? static_cast<double>(films[i].film.passes()) * (best / v) : 0);
  }
  return weights;
}

}  // namespace

std::vector<double> CombinationWeights(std::span<const IterationFilm> films, const Method::Combination& combination) {
  std::vector<double> weights(films.size());
  if (films.empty()) return weights;
  if (combination.kind == Kind::kInverseVariance) {
    const size_t used = std::min<size_t>(films.size(), std::max(1u, combination.last));
    const std::vector<double> last = InverseVarianceWeights(films.last(used));
    std::copy(last.begin(), last.end(), weights.end() - static_cast<std::ptrdiff_t>(used));
  } else {
    size_t most = 0;
    for (size_t i = 1; i < films.size(); ++i) {
      if (films[i].film.passes() >= films[most].film.passes()) most = i;
    }
    weights[most] = films[most].film.passes() > 0 ? 1 : 0;
  }
  double total = 0;
  for (const double w : weights) total += w;
  for (double& w : weights) w = total > 0 ? w / total : 0;
  return weights;
}

Image Combine(std::span<const IterationFilm> films, std::span<const double> weights) {
  LODESTAR_CHECK(!films.empty() && films.size() == weights.size());
  const auto only = std::find(weights.begin(), weights.end(), 1.0);
  if (only != weights.end()) return films[static_cast<size_t>(only - weights.begin())].film.Develop();
  Image sum;
  sum.width = films[0].film.width();
  sum.height = films[0].film.height();
  sum.pixels.resize(size_t{sum.width} * sum.height);
  sum.variance.resize(sum.pixels.size());
  for (size_t i = 0; i < films.size(); ++i) {
    if (weights[i] == 0) continue;
    const Image image = films[i].film.Develop();
    const auto w = static_cast<float>(weights[i]);
    for (size_t p = 0; p < sum.pixels.size(); ++p) {
      sum.pixels[p] += image.pixels[p] * w;
      sum.variance[p] += image.variance[p] * (w * w);
    }
  }
  return sum;
}

uint64_t CombinedPasses(std::span<const IterationFilm> films, std::span<const double> weights) {
  uint64_t passes = 0;
  for (size_t i = 0; i < films.size(); ++i) {
    if (weights[i] > 0) passes += films[i].film.passes();
  }
  return passes;
}

size_t FilmsToKeep(const Method::Combination& combination) {
  return combination.kind == Kind::kInverseVariance ? std::max(1u, combination.last) - 1 : 1;
}

}  // namespace lodestar
