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

// Each film as a picture. A film of one pass cannot tell its own variance; the mean of the n passes of the others can:
// the square of what lies between the two has the mean v + w / n, of which n / (n + 1) is v where passes are alike. All
// variances stay 0 where there is one pass in all.
std::vector<Image> DevelopAll(std::span<const IterationFilm> films) {
  std::vector<Image> images;
  uint64_t passes = 0;
  for (const auto& [iteration, film] : films) {
    images.push_back(film.Develop());
    passes += film.passes();
  }
  std::vector<double> sum;  // of luminance, over all passes
  for (size_t i = 0; i < films.size(); ++i) {
    if (films[i].film.passes() != 1 || passes == 1) continue;
    if (sum.empty()) {
      sum.resize(images[i].size());
      for (size_t j = 0; j < films.size(); ++j) {
        for (size_t p = 0; p < sum.size(); ++p)
          sum[p] += static_cast<double>(films[j].film.passes()) * Luminance(images[j].pixels[p]);
      }
    }
    const auto others = static_cast<double>(passes - 1);
    for (size_t p = 0; p < sum.size(); ++p) {
      const double own = Luminance(images[i].pixels[p]), apart = own - (sum[p] - own) / others;
      images[i].variance[p] = static_cast<float>(
          std::min<double>(apart * apart * others / (others + 1), std::numeric_limits<float>::max()));
    }
  }
  return images;
}

Image WeightedMean(std::span<const Image> images, std::span<const double> weights) {
  const auto only = std::find(weights.begin(), weights.end(), 1.0);
  if (only != weights.end()) return images[static_cast<size_t>(only - weights.begin())];
  Image sum;
  sum.width = images[0].width;
  sum.height = images[0].height;
  sum.pixels.resize(size_t{sum.width} * sum.height);
  sum.variance.resize(sum.pixels.size());
  for (size_t i = 0; i < images.size(); ++i) {
    if (weights[i] == 0) continue;
    const auto w = static_cast<float>(weights[i]);
    for (size_t p = 0; p < sum.pixels.size(); ++p) {
      sum.pixels[p] += images[i].pixels[p] * w;
      sum.variance[p] += images[i].variance[p] * (w * w);
    }
  }
  return sum;
}

// Variance of a film's picture relative to what the pixels are expected to have, mean over the pixels; the worst left
// out, as in reports, unless they hold more than kOutliersLight of the film's light: then they are not outliers but
// what there is, and relative to the mean of all pixels, since what is expected of them is mostly themselves.
double MeanRelativeVariance(const Image& image, const PixelEstimate& expected) {
  constexpr double kOutliersLight = 0.25;
  double mean = 0;
  for (size_t i = 0; i < image.size(); ++i) mean += expected.luminance[i] / static_cast<double>(image.size());
  const double epsilon = RelativeEpsilon(mean);
  std::vector<double> relative(image.size());
  for (size_t i = 0; i < image.size(); ++i) {
    const double pixel = expected.luminance[i];
    relative[i] = image.variance[i] / (pixel * pixel + epsilon);
  }
  const double most = LargestKept(relative, kTrimmedFraction);
  double kept = 0, outliers = 0, kept_light = 0, outliers_light = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    const bool outlier = relative[i] > most;
    if (outlier) {
      outliers += image.variance[i];
    } else {
      kept += relative[i];
    }
    (outlier ? outliers_light : kept_light) += Luminance(image.pixels[i]);
  }
  outliers /= mean * mean + epsilon;
  const bool trimmed = outliers_light <= kOutliersLight * (kept_light + outliers_light);
  return (trimmed ? kept : kept + outliers) / static_cast<double>(image.size());
}

std::vector<double> InverseVarianceWeights(std::span<const IterationFilm> films, std::span<const Image> images) {
  // What each pixel is expected to have: all passes count alike.
  std::vector<double> by_passes;
  uint64_t passes = 0;
  for (const auto& [iteration, film] : films) passes += film.passes();
  if (passes == 0) return std::vector<double>(films.size());
  for (const auto& [iteration, film] : films)
    by_passes.push_back(static_cast<double>(film.passes()) / static_cast<double>(passes));
  if (std::ranges::find(by_passes, 1.0) != by_passes.end()) return by_passes;
  const PixelEstimate expected = EstimatePixels(WeightedMean(images, by_passes));

  std::vector<double> per_pass;
  double best = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < films.size(); ++i) {
    const auto n = static_cast<double>(films[i].film.passes());
    const double v = n > 0 ? MeanRelativeVariance(images[i], expected) * n : 0;
    per_pass.push_back(v);
    if (v > 0) best = std::min(best, v);
  }
  if (!std::isfinite(best)) best = 1;  // nothing varies: passes alone count
  std::vector<double> weights;
  for (size_t i = 0; i < films.size(); ++i)
    weights.push_back(by_passes[i] * (per_pass[i] == 0 ? 1 : best / per_pass[i]));
  return weights;
}

}  // namespace

CombinedFilms Combine(std::span<const IterationFilm> films, const Method::Combination& combination) {
  LODESTAR_CHECK(!films.empty());
  CombinedFilms result;
  result.weights.resize(films.size());
  if (combination.kind != Kind::kInverseVariance) {
    size_t most = 0;
    for (size_t i = 1; i < films.size(); ++i) {
      if (films[i].film.passes() >= films[most].film.passes()) most = i;
    }
    result.passes = films[most].film.passes();
    result.weights[most] = result.passes > 0 ? 1 : 0;
    result.image = films[most].film.Develop();
    return result;
  }
  const size_t used = std::min<size_t>(films.size(), std::max(1u, combination.last));
  const std::span<double> weights = std::span(result.weights).last(used);
  const std::vector<Image> images = DevelopAll(films.last(used));
  std::ranges::copy(InverseVarianceWeights(films.last(used), images), weights.begin());
  double total = 0;
  for (const double w : weights) total += w;
  for (double& w : weights) w = total > 0 ? w / total : 0;
  result.image = WeightedMean(images, weights);
  for (size_t i = 0; i < films.size(); ++i) {
    if (result.weights[i] > 0) result.passes += films[i].film.passes();
  }
  return result;
}

size_t FilmsToKeep(const Method::Combination& combination) {
  return combination.kind == Kind::kInverseVariance ? std::max(1u, combination.last) - 1 : 1;
}

}  // namespace lodestar
