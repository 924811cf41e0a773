#include "core/learning/combination.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/check.h"
#include "core/film/error_metrics.h"
#include "core/film/pixel_estimate.h"

namespace lodestar {
namespace {

using Combination = Method::Combination;

constexpr size_t kApart = 2;  // films of the last candidate, beside the one that holds its earlier ones

// Each film as a picture. A film of one pass cannot tell its own variance; the mean of the n passes of the others can:
// the square of what lies between the two has the mean v + w / n, of which n / (n + 1) is v where passes are alike. All
// variances stay 0 where there is one pass in all.
std::vector<Image> DevelopAll(std::span<const IterationFilm> films) {
  std::vector<Image> images;
  uint64_t passes = 0;
  for (const IterationFilm& film : films) {
    images.push_back(film.film.Develop());
    passes += film.film.passes();
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

// Variance of a film's picture relative to what the pixels are expected to have, mean over the pixels, the worst left
// out: as many as samples in the worst pixels of the job's image are the film's, whose share of the passes is `share`.
double MeanRelativeVariance(const Image& image, const PixelEstimate& expected, double share) {
  double mean = 0;
  for (size_t i = 0; i < image.size(); ++i) mean += expected.luminance[i] / static_cast<double>(image.size());
  const double epsilon = RelativeEpsilon(mean);
  std::vector<double> relative(image.size());
  for (size_t i = 0; i < image.size(); ++i) {
    const double pixel = expected.luminance[i];
    relative[i] = image.variance[i] / (pixel * pixel + epsilon);
  }
  return TrimmedVariance(image, relative, mean * mean + epsilon, share * kTrimmedFraction);
}

// Guides get better as they learn: of one candidate's films none should be noisier per pass than the one before. Where
// it looks so, the earlier one has hardly met what the later one shows; then both have the mean of what was seen,
// passes counting alike (isotonic regression by pooling neighbours; Ayer et al. 1955).
void PoolWhereLaterIsNoisier(std::span<const IterationFilm> films, std::vector<double>* per_pass) {
  struct Run {
    double sum = 0, passes = 0;
    std::vector<size_t> films;
    double Mean() const { return sum / passes; }
  };
  std::map<uint32_t, std::vector<Run>> runs;  // by candidate
  for (size_t i = 0; i < films.size(); ++i) {
    const auto n = static_cast<double>(films[i].film.passes());
    if (n == 0) continue;
    std::vector<Run>& own = runs[films[i].candidate];
    own.push_back({(*per_pass)[i] * n, n, {i}});
    for (; own.size() > 1 && own.back().Mean() > own[own.size() - 2].Mean(); own.pop_back()) {
      const Run& later = own.back();
      Run& earlier = own[own.size() - 2];
      earlier.sum += later.sum;
      earlier.passes += later.passes;
      earlier.films.insert(earlier.films.end(), later.films.begin(), later.films.end());
    }
  }
  for (const auto& [candidate, own] : runs) {
    for (const Run& run : own) {
      for (const size_t i : run.films) (*per_pass)[i] = run.Mean();
    }
  }
}

std::vector<double> InverseVarianceWeights(std::span<const IterationFilm> films, std::span<const Image> images) {
  // What each pixel is expected to have: all passes count alike.
  std::vector<double> by_passes;
  uint64_t passes = 0;
  for (const IterationFilm& film : films) passes += film.film.passes();
  if (passes == 0) return std::vector<double>(films.size());
  for (const IterationFilm& film : films)
    by_passes.push_back(static_cast<double>(film.film.passes()) / static_cast<double>(passes));
  if (std::ranges::find(by_passes, 1.0) != by_passes.end()) return by_passes;
  const PixelEstimate expected = EstimatePixels(WeightedMean(images, by_passes));

  std::vector<double> per_pass;
  for (size_t i = 0; i < films.size(); ++i) {
    const auto n = static_cast<double>(films[i].film.passes());
    per_pass.push_back(n > 0 ? MeanRelativeVariance(images[i], expected, by_passes[i]) * n : 0);
  }
  PoolWhereLaterIsNoisier(films, &per_pass);
  const double worst = *std::ranges::max_element(per_pass);
  std::vector<double> weights;
  for (size_t i = 0; i < films.size(); ++i)
    weights.push_back(by_passes[i] * (per_pass[i] == 0 ? 1 : worst / per_pass[i]));
  return weights;
}

}  // namespace

CombinedFilms Combine(std::span<const IterationFilm> films, Combination combination) {
  LODESTAR_CHECK(!films.empty());
  CombinedFilms result;
  if (combination != Combination::kInverseVariance) {
    result.weights.resize(films.size());
    size_t most = 0;
    for (size_t i = 1; i < films.size(); ++i) {
      if (films[i].film.passes() >= films[most].film.passes()) most = i;
    }
    result.passes = films[most].film.passes();
    result.weights[most] = result.passes > 0 ? 1 : 0;
    result.image = films[most].film.Develop();
    return result;
  }
  const std::vector<Image> images = DevelopAll(films);
  result.weights = InverseVarianceWeights(films, images);
  double total = 0;
  for (const double w : result.weights) total += w;
  for (double& w : result.weights) w = total > 0 ? w / total : 0;
  result.image = WeightedMean(images, result.weights);
  for (size_t i = 0; i < films.size(); ++i) {
    if (result.weights[i] > 0) result.passes += films[i].film.passes();
  }
  return result;
}

size_t MostFilms(Combination combination) {
  const size_t left = combination == Combination::kInverseVariance ? 1 + kApart : 1;
  return left + 1;
}

void MakeRoom(std::vector<IterationFilm>* films, Combination combination, std::span<const double> weights) {
  LODESTAR_CHECK(weights.size() == films->size());
  if (films->empty()) return;
  if (combination != Combination::kInverseVariance) {
    films->erase(films->begin(), films->end() - 1);
    return;
  }
  std::vector<size_t> own;
  for (size_t i = 0; i < films->size(); ++i) {
    if ((*films)[i].candidate == films->back().candidate) own.push_back(i);
  }
  if (own.size() <= 1 + kApart) return;
  const size_t a = own[0], b = own[1];
  std::vector<Image> images = DevelopAll(*films);
  const double both = weights[a] + weights[b], share = both > 0 ? weights[a] / both : 0;
  const std::array pair = {std::move(images[a]), std::move(images[b])};
  IterationFilm &pool = (*films)[a], &next = (*films)[b];
  pool.film = Film(WeightedMean(pair, std::array{share, 1 - share}), pool.film.passes() + next.film.passes());
  pool.rays += next.rays;
  pool.vertices += next.vertices;
  pool.seconds += next.seconds;
  films->erase(films->begin() + static_cast<std::ptrdiff_t>(b));
}

}  // namespace lodestar
