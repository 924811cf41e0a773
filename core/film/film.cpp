#include "core/film/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace lodestar {
namespace {

// A sum that would leave the range of float stays at its end: one firefly must not turn a tile into a refused
// contribution.
float SaturatingAdd(float sum, float value) {
  constexpr float kMax = std::numeric_limits<float>::max();
  return std::clamp(sum + value, -kMax, kMax);
}

}  // namespace

TileRect TileGrid::Rect(uint32_t tile) const {
  LODESTAR_CHECK(tile < tile_count());
  const uint32_t x0 = tile % columns_ * kTileSize, y0 = tile / columns_ * kTileSize;
  return {x0, y0, std::min(x0 + kTileSize, width_), std::min(y0 + kTileSize, height_)};
}

bool PixelSum::Add(Rgb sample) {
  LODESTAR_DCHECK(IsFinite(sample));
  const float luminance = Luminance(sample);
  r = SaturatingAdd(r, sample.r);
  g = SaturatingAdd(g, sample.g);
  b = SaturatingAdd(b, sample.b);
  luminance_squared = SaturatingAdd(luminance_squared, luminance * luminance);
  constexpr float kMax = std::numeric_limits<float>::max();
  return std::max({r, g, b, luminance_squared}) < kMax;
}

Film::Film(const TileGrid& grid)
    : width_(grid.width()), height_(grid.height()), sums_(size_t{grid.width()} * grid.height()) {}

Film::Film(const Image& image, uint64_t passes)
    : width_(image.width), height_(image.height), passes_(passes), sums_(image.size()) {
  LODESTAR_CHECK(passes >= 2 && image.variance.size() == image.size());
  const auto n = static_cast<double>(passes);
  for (size_t i = 0; i < sums_.size(); ++i) {
    Sum& sum = sums_[i];
    sum.r = n * image.pixels[i].r;
    sum.g = n * image.pixels[i].g;
    sum.b = n * image.pixels[i].b;
    const double mean = MeanLuminance(sum);
    sum.luminance_squared = n * ((n - 1) * image.variance[i] + mean * mean);
  }
}

void Film::Add(const TileGrid& grid, const FilmTile& tile) {
  LODESTAR_CHECK(grid.width() == width_ && grid.height() == height_);
  const TileRect rect = grid.Rect(tile.tile);
  LODESTAR_CHECK(tile.pixels.size() == rect.pixels());
  const PixelSum* from = tile.pixels.data();
  for (uint32_t y = rect.y0; y < rect.y1; ++y) {
    Sum* to = &sums_[size_t{y} * width_ + rect.x0];
    for (uint32_t x = rect.x0; x < rect.x1; ++x, ++from, ++to) {
      to->r += from->r;
      to->g += from->g;
      to->b += from->b;
      to->luminance_squared += from->luminance_squared;
    }
  }
}

double Film::MeanLuminance(const Sum& sum) const {
  return (0.212671 * sum.r + 0.715160 * sum.g + 0.072169 * sum.b) / static_cast<double>(passes_);
}

double Film::Variance(const Sum& sum) const {
  if (passes_ < 2) return 0;
  const double n = static_cast<double>(passes_), mean = MeanLuminance(sum);
  // Sample variance over n; never negative, where rounding of nearly equal samples would make it so.
  return std::max(0.0, (sum.luminance_squared / n - mean * mean) / (n - 1));
}

Image Film::Develop() const {
  Image image;
  image.width = width_;
  image.height = height_;
  image.pixels.resize(sums_.size());
  image.variance.resize(sums_.size());
  if (passes_ == 0) return image;
  const double n = static_cast<double>(passes_);
  for (size_t i = 0; i < sums_.size(); ++i) {
    const Sum& sum = sums_[i];
    image.pixels[i] = {static_cast<float>(sum.r / n), static_cast<float>(sum.g / n), static_cast<float>(sum.b / n)};
    image.variance[i] = static_cast<float>(std::min<double>(Variance(sum), std::numeric_limits<float>::max()));
  }
  return image;
}

double Film::MeanVariance(double clamp) const {
  if (passes_ < 2) return std::numeric_limits<double>::infinity();
  // The median is over the pixels that vary at all: in a picture that is mostly black the plain median is 0 and would
  // clamp everything away.
  std::vector<double> variances, positive;
  variances.reserve(sums_.size());
  for (const Sum& sum : sums_) variances.push_back(Variance(sum));
  for (const double v : variances) {
    if (v > 0) positive.push_back(v);
  }
  if (positive.empty()) return 0;
  const auto middle = positive.begin() + static_cast<std::ptrdiff_t>(positive.size() / 2);
  std::nth_element(positive.begin(), middle, positive.end());
  const double limit = clamp * *middle;
  double total = 0;
  for (const double v : variances) total += std::min(v, limit);
  return total / static_cast<double>(variances.size());
}

void Film::Write(ByteWriter& out) const {
  out.Put(width_);
  out.Put(height_);
  out.Put(passes_);
  out.PutVector(sums_);
}

Film Film::Read(ByteReader& in) {
  Film film;
  film.width_ = in.Get<uint32_t>();
  film.height_ = in.Get<uint32_t>();
  film.passes_ = in.Get<uint64_t>();
  film.sums_ = in.GetVector<Sum>();
  if (film.sums_.size() != size_t{film.width_} * film.height_) in.Fail("has a film whose size does not fit its pixels");
  for (const Sum& s : film.sums_) {
    if (!std::isfinite(s.r) || !std::isfinite(s.g) || !std::isfinite(s.b) || !(s.luminance_squared >= 0) ||
        !std::isfinite(s.luminance_squared)) {
      in.Fail("has a film with a pixel that is not finite");
    }
  }
  return film;
}

}  // namespace lodestar
