// Means of whole pictures and of their quadrants over independent seeds, for t-tests of one method against another.
#pragma once

#include <array>
#include <map>
#include <string>

#include "tests/support/render.h"
#include "tests/support/statistical.h"

namespace lodestar::test {

inline constexpr int kRegions = 5;  // four quadrants and the whole
using ImageMeans = std::array<Moments, kRegions>;

inline void AddImage(const Image& image, ImageMeans* means, double scale = 1) {
  std::array<double, kRegions> sums{};
  for (uint32_t y = 0; y < image.height; ++y)
    for (uint32_t x = 0; x < image.width; ++x) {
      const double value = scale * Luminance(image.pixels[size_t(y) * image.width + x]);
      sums[(y * 2 / image.height) * 2 + x * 2 / image.width] += value;
      sums[4] += value;
    }
  for (int i = 0; i < kRegions; ++i) (*means)[i].Add(sums[i] / static_cast<double>(image.size()));
}

// `job` names all but the seed; the images are multiplied by `scale`, for showing that a wrong mean is seen.
inline ImageMeans RenderSeeds(const CompiledJob& compiled, JobSpec job, int seeds, uint64_t first_seed,
                              double scale = 1) {
  ImageMeans means;
  for (int seed = 0; seed < seeds; ++seed) {
    job.seed = first_seed + static_cast<uint64_t>(seed);
    AddImage(Render(compiled, job).image, &means, scale);
  }
  return means;
}

}  // namespace lodestar::test
