// A smoothed estimate of every pixel's luminance, for methods that weigh paths by what their pixel expects.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/film/film.h"

namespace lodestar {

struct PixelEstimate {
  uint32_t width = 0, height = 0;
  std::vector<float> luminance;  // above zero wherever the image is not black as a whole; then 1 everywhere

  bool empty() const { return luminance.empty(); }
  float At(uint32_t x, uint32_t y) const { return luminance[size_t{y} * width + x]; }
  void Write(ByteWriter& out) const;
  // Fails the reader (Error kCorrupt) where sizes do not fit or a value is not above zero.
  static PixelEstimate Read(ByteReader& in);
};

// The image's luminance, no pixel above twice the mean of its neighbours, through three 3x3 box filters, edges repeated,
// and no lower than a hundredth of its mean: a relative floor, so that the scale of the scene's light does not matter
// (Rath et al. 2020 add an absolute one).
PixelEstimate EstimatePixels(const Image& image);

}  // namespace lodestar
