// Pictures of a focal field (Sadek 2025, section 3.8.1): the largest or the average density that a ray meets, for every
// pixel. Densities are relative: 1 is a field without a focus. Whoever shows them chooses thresholds and colours.
#pragma once

#include <functional>

#include "core/guiding/focal_field.h"

namespace lodestar {

struct FocalProjection {
  enum class Kind : uint8_t { kMaximum, kAverage };
  uint32_t width = 0, height = 0;
  std::vector<float> values;  // row by row from the top; 0 where the ray misses the box
};

// The ray of a pixel: where it begins, its direction (of unit length), and how far it counts; infinity for all of it.
struct FocalPixelRay {
  Vec3 origin, direction;
  float distance = kInfinity;
};

FocalProjection Project(const FocalField& field, FocalProjection::Kind kind, uint32_t width, uint32_t height,
                        const std::function<FocalPixelRay(uint32_t x, uint32_t y)>& ray);

// Along an axis through the whole box, `width` pixels wide and as high as its sides demand; the next two axes point
// right and up.
FocalProjection ProjectAlong(const FocalField& field, FocalProjection::Kind kind, int axis, uint32_t width);

}  // namespace lodestar
