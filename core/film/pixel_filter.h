// Reconstruction filters, sampled by importance so that a sample belongs to the pixel it was drawn for alone (Ernst et
// al. 2006) and a pixel to one tile. A filter with negative lobes is sampled by its absolute value and carries its sign
// in the weight.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math/vec.h"

namespace lodestar {

struct FilterSample {
  Vec2 offset;       // from the pixel's centre, in pixels
  float weight = 1;  // normalised: its mean over samples is 1
};

class PixelFilter {
 public:
  enum class Kind { kBox, kTriangle, kGaussian, kMitchell };
  struct Parameters {
    Kind kind = Kind::kBox;
    float radius_x = 0.5f, radius_y = 0.5f;
    float sigma = 0.5f;
    float b = 1 / 3.0f, c = 1 / 3.0f;
  };
  explicit PixelFilter(const Parameters& parameters);
  FilterSample Sample(Vec2 u) const;
  // The unnormalized filter at an offset from the centre.
  static float Evaluate(const Parameters& parameters, Vec2 offset);

 private:
  // Each filter here is separable: one table of the absolute value's cumulative distribution (GuidedCdf) an axis.
  struct Axis {
    float radius = 0.5f;
    std::vector<float> ends;
    std::vector<uint16_t> guide;
    std::vector<float> sign;
    float weight_scale = 1;
    Vec2 Sample(float u) const;  // (offset, weight)
  };
  bool box_ = true;
  Axis x_, y_;
};

}  // namespace lodestar
