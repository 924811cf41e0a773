// Pictures of a focal field's octrees (Sadek 2025, section 3.8.1): the greatest or the average density that a line of
// sight meets. Densities are relative to the field's mean: 1 is a field without a focus. Whoever shows them chooses
// thresholds and colours.
#pragma once

#include <functional>

#include "core/guiding/focal_field.h"
#include "core/guiding/guide_picture.h"

namespace lodestar {

enum class FocalProjection : uint8_t { kMaximum, kAverage };

// The ray of a pixel: where it begins, its direction (of unit length), and how far it counts; infinity for all of it.
struct FocalPixelRay {
  Vec3 origin, direction;
  float distance = kInfinity;
};

// Averages are over the part of the ray in the box; 0 where it misses the box. `ray` is called from several threads.
FloatGrid Project(const FocalField& field, size_t octree, FocalProjection projection, uint32_t width, uint32_t height,
                  const std::function<FocalPixelRay(uint32_t x, uint32_t y)>& ray);

// Along an axis through the whole box, which fills the picture (guide_picture_space.h). Voxels smaller than a pixel are
// not missed: the greatest of all that it covers, or the average over its area, whose mean over all pixels is the
// octree's share of the mass.
FloatGrid ProjectAlong(const FocalField& field, size_t octree, FocalProjection projection, int axis, uint32_t longest);

}  // namespace lodestar
