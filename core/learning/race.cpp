#include "core/learning/race.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/film/error_metrics.h"
#include "core/math/elementary.h"

namespace lodestar {
namespace {

// Part of the pixels that is left out, the worst: half of what reports leave out. Between none, where one outlier
// decides, and all of that, where the noise of few passes hides (docs/decisions/0013-auto.md).
constexpr double kLeftOut = kTrimmedFraction / 2;
// Rare samples lie in as many more pixels as there are passes: of films of fewer than these, fewer pixels are left out,
// so that the same share of samples is.
constexpr double kPassesOfLeftOut = 16;

// Cuts an image into blocks, at most eight along each side.
class Blocks {
 public:
  explicit Blocks(const Image& image)
      : width_(image.width),
        height_(image.height),
        columns_(std::min(kSide, image.width)),
        rows_(std::min(kSide, image.height)) {}
  size_t count() const { return size_t{columns_} * rows_; }
  size_t At(uint32_t x, uint32_t y) const {
    return size_t{y} * rows_ / height_ * columns_ + size_t{x} * columns_ / width_;
  }
  // Pixels of each.
  std::vector<double> Pixels() const {
    std::vector<double> pixels(count());
    for (uint32_t y = 0; y < height_; ++y) {
      for (uint32_t x = 0; x < width_; ++x) ++pixels[At(x, y)];
    }
    return pixels;
  }

 private:
  static constexpr uint32_t kSide = 8;
  uint32_t width_, height_, columns_, rows_;
};

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

Yardstick::Yardstick(const Image& image) : pixels_(EstimatePixels(image)) {
  const Blocks blocks(image);
  blocks_.resize(blocks.count());
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x)
      blocks_[blocks.At(x, y)] += Luminance(image.pixels[size_t{y} * image.width + x]);
  }
  const std::vector<double> pixels = blocks.Pixels();
  double mean = 0;
  for (size_t block = 0; block < blocks_.size(); ++block) {
    mean += blocks_[block] / static_cast<double>(image.size());
    blocks_[block] /= pixels[block];
  }
  epsilon_ = RelativeEpsilon(mean);
}

PilotResult MeasurePilot(uint32_t candidate, const Film& film, double work, const Yardstick& yardstick) {
  LODESTAR_CHECK(film.passes() >= 2);
  const auto passes = static_cast<double>(film.passes());
  PilotResult result;
  result.candidate = candidate;
  result.passes = film.passes();
  result.work = work / passes;
  const Image image = film.Develop();
  const Blocks blocks(image);
  LODESTAR_CHECK(blocks.count() == yardstick.blocks().size());

  // 1. Each pixel's relative variance, the worst left out.
  std::vector<double> values(image.size());
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const double expected = yardstick.pixels().At(x, y);
      const size_t i = size_t{y} * image.width + x;
      values[i] = image.variance[i] * passes / (expected * expected + yardstick.epsilon());
    }
  }
  const double most = LargestKept(values, kLeftOut * std::min(1.0, passes / kPassesOfLeftOut));

  // 2. By block.
  std::vector<double> light(blocks.count());
  result.variances.resize(blocks.count());
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const size_t i = size_t{y} * image.width + x, block = blocks.At(x, y);
      if (values[i] <= most) result.variances[block] += values[i];
      light[block] += Luminance(image.pixels[i]);
    }
  }
  const std::vector<double> pixels = blocks.Pixels();
  for (size_t block = 0; block < blocks.count(); ++block) {
    double& variance = result.variances[block];
    variance /= pixels[block];
    // 3. The light that is missing.
    const double expected = yardstick.blocks()[block];
    const double missing = std::max(0.0, expected - light[block] / pixels[block]);
    const double implied = missing * missing / (expected * expected + yardstick.epsilon()) * pixels[block] * passes;
    if (implied > 25 * variance) variance = implied;
  }
  return result;
}

EfficiencyRatio CompareEfficiency(const PilotResult& a, const PilotResult& b) {
  LODESTAR_CHECK(a.variances.size() == b.variances.size() && !a.variances.empty());
  const double value = Ratio(a, b);
  const auto n = static_cast<double>(a.variances.size());
  // Efron and Stein 1981: the jackknife's variance, of the logarithm: what a over b is in doubt of, b over a is as
  // well. 2 (v - w) / (v + w) stands for log(v / w), which it is near 1, and turns its sign when v and w change places.
  double mean = 0, squares = 0;
  std::vector<double> left_out;
  for (size_t i = 0; i < a.variances.size(); ++i) {
    const double v = Ratio(a, b, i);
    left_out.push_back(2 * (v - value) / (v + value));
  }
  for (const double v : left_out) mean += v / n;
  for (const double v : left_out) squares += (v - mean) * (v - mean);
  const double error = n > 1 ? std::sqrt(squares * (n - 1) / n) : 1.0;
  const auto factor = static_cast<double>(Exp(static_cast<float>(std::min(1.96 * error, 80.0))));
  return {value, value / factor, value * factor};
}

double RelativeVariance(const Film& film) {
  double sum = 0;
  const Image image = film.Develop();
  for (const Rgb& pixel : image.pixels) sum += Luminance(pixel);
  const double mean = sum / static_cast<double>(std::max<size_t>(1, image.size()));
  if (!(mean > 0) || film.passes() < 2) return std::numeric_limits<double>::infinity();
  return film.MeanVariance() * static_cast<double>(film.passes()) / (mean * mean);
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
