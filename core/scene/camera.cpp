#include "core/scene/camera.h"

#include "core/math/elementary.h"
#include "core/math/warp.h"

namespace lodestar {

Camera::Camera(const CameraDescription& description, int resolution_x, int resolution_y)
    : lens_radius_(description.lens_radius), focal_distance_(description.focal_distance) {
  const auto& m = description.camera_from_world.inverse_matrix();
  const auto column = [&m](int c) { return Vec3{float(m[0][c]), float(m[1][c]), float(m[2][c])}; };
  right_ = column(0);
  up_ = column(1);
  forward_ = column(2);
  origin_ = column(3);

  // The screen window: [-1, 1] along the shorter axis unless the file says otherwise.
  const float aspect = float(resolution_x) / float(resolution_y);
  auto [x0, x1, y0, y1] = description.screen_window;
  if (description.screen_window == std::array<float, 4>{0, 0, 0, 0}) {
    const float wide = std::max(aspect, 1.0f), tall = std::max(1 / aspect, 1.0f);
    x0 = -wide, x1 = wide, y0 = -tall, y1 = tall;
  }
  const float tan_half = Tan(Radians(description.fov) / 2);
  x_scale_ = (x1 - x0) / float(resolution_x) * tan_half;
  x_offset_ = x0 * tan_half;
  y_scale_ = (y0 - y1) / float(resolution_y) * tan_half;  // film y points down
  y_offset_ = y1 * tan_half;
}

CameraRay Camera::Generate(Vec2 film, Vec2 lens) const {
  const Vec3 plane{film.x * x_scale_ + x_offset_, film.y * y_scale_ + y_offset_, 1};
  if (lens_radius_ <= 0) return {origin_, Normalize(right_ * plane.x + up_ * plane.y + forward_)};
  // All rays of a film point meet on the plane of focus.
  const Vec2 disk = SquareToDisk(lens) * lens_radius_;
  const Vec3 d{plane.x * focal_distance_ - disk.x, plane.y * focal_distance_ - disk.y, focal_distance_};
  return {origin_ + right_ * disk.x + up_ * disk.y, Normalize(right_ * d.x + up_ * d.y + forward_ * d.z)};
}

}  // namespace lodestar
