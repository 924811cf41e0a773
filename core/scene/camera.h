// pbrt's perspective camera: left-handed camera space, +z forward, +y up; `fov` spans the shorter image axis.
#pragma once

#include "core/math/transform.h"
#include "core/scene/description.h"

namespace lodestar {

struct CameraRay {
  Vec3 origin;
  Vec3 direction;  // unit
};

class Camera {
 public:
  Camera(const CameraDescription& description, int resolution_x, int resolution_y);

  // film: continuous pixel coordinates, (0,0) the upper left corner of the image; lens: uniform in the unit square
  // (unused without a lens).
  CameraRay Generate(Vec2 film, Vec2 lens) const;
  bool has_lens() const { return lens_radius_ > 0; }

 private:
  Vec3 origin_;  // world
  Vec3 right_, up_,
      forward_;  // world images of the camera axes (columns of world-from-camera; the file's scaling kept)
  float x_scale_, x_offset_, y_scale_, y_offset_;  // film coordinates to the plane z = 1 of camera space
  float lens_radius_, focal_distance_;
};

}  // namespace lodestar
