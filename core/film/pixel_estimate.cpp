#include "core/film/pixel_estimate.h"

#include <algorithm>
#include <cmath>

namespace lodestar {
namespace {

constexpr int kFilterSteps = 3;
constexpr double kFloor = 0.01;
constexpr float kMostAboveNeighbours = 2;

// Three neighbours along one axis, summed in a fixed order.
void BoxFilter(std::vector<float>* values, uint32_t width, uint32_t height, bool along_x) {
  std::vector<float> out(values->size());
  const uint32_t last_x = width - 1, last_y = height - 1;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const auto at = [&](uint32_t px, uint32_t py) { return (*values)[size_t{py} * width + px]; };
      const float before = along_x ? at(x - (x > 0), y) : at(x, y - (y > 0));
      const float after = along_x ? at(std::min(x + 1, last_x), y) : at(x, std::min(y + 1, last_y));
      out[size_t{y} * width + x] = before * (1 / 3.0f) + at(x, y) * (1 / 3.0f) + after * (1 / 3.0f);
    }
  }
  *values = std::move(out);
}

// No value above twice the mean of its up to eight neighbours. What a few samples have met by chance would else count
// as expected where they met it, and hide their own variance (docs/decisions/0013-auto.md).
void ClampToNeighbours(std::vector<float>* values, uint32_t width, uint32_t height) {
  std::vector<float> out(*values);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t x0 = x - (x > 0), x1 = std::min(x + 1, width - 1), y0 = y - (y > 0),
                     y1 = std::min(y + 1, height - 1);
      const uint32_t neighbours = (x1 - x0 + 1) * (y1 - y0 + 1) - 1;
      if (neighbours == 0) continue;
      float sum = 0;
      for (uint32_t ny = y0; ny <= y1; ++ny) {
        for (uint32_t nx = x0; nx <= x1; ++nx) {
          if (nx != x || ny != y) sum += (*values)[size_t{ny} * width + nx] / static_cast<float>(neighbours);
        }
      }
      float& value = out[size_t{y} * width + x];
      value = std::min(value, kMostAboveNeighbours * sum);
    }
  }
  *values = std::move(out);
}

}  // namespace

PixelEstimate EstimatePixels(const Image& image) {
  PixelEstimate estimate{image.width, image.height, {}};
  estimate.luminance.reserve(image.size());
  double sum = 0;
  for (const Rgb& pixel : image.pixels) {
    estimate.luminance.push_back(std::max(0.0f, Luminance(pixel)));
    sum += estimate.luminance.back();
  }
  const double mean = sum / static_cast<double>(std::max<size_t>(1, image.size()));
  const float floor = static_cast<float>(std::min(mean * kFloor, 1e37));
  if (!(floor > 0)) {
    std::fill(estimate.luminance.begin(), estimate.luminance.end(), 1.0f);
    return estimate;
  }
  ClampToNeighbours(&estimate.luminance, image.width, image.height);
  for (int step = 0; step < kFilterSteps; ++step) {
    BoxFilter(&estimate.luminance, image.width, image.height, true);
    BoxFilter(&estimate.luminance, image.width, image.height, false);
  }
  for (float& value : estimate.luminance) value = std::max(value, floor);
  return estimate;
}

void PixelEstimate::Write(ByteWriter& out) const {
  out.Put(width);
  out.Put(height);
  out.PutVector(luminance);
}

PixelEstimate PixelEstimate::Read(ByteReader& in) {
  PixelEstimate estimate;
  estimate.width = in.Get<uint32_t>();
  estimate.height = in.Get<uint32_t>();
  estimate.luminance = in.GetVector<float>();
  const uint64_t pixels = uint64_t{estimate.width} * estimate.height;
  if (estimate.luminance.size() != pixels) in.Fail("has a pixel estimate of another size than it says");
  for (const float value : estimate.luminance) {
    if (!(value > 0) || !std::isfinite(value)) in.Fail("has a pixel estimate that is not above zero");
  }
  return estimate;
}

}  // namespace lodestar
