#include "core/scene/camera.h"

#include <gtest/gtest.h>

#include "core/math/warp.h"

namespace lodestar {
namespace {

void ExpectNear(Vec3 a, Vec3 b, float tolerance = 1e-6f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Camera, FieldOfViewSpansTheShorterAxis) {
  CameraDescription d;
  d.fov = 90;
  const Camera wide(d, 200, 100);
  ExpectNear(wide.Generate({100, 50}, {}).direction, {0, 0, 1});
  // Upper edge: y = +1 on the plane z = 1; right edge: x = 2.
  ExpectNear(wide.Generate({100, 0}, {}).direction, Normalize(Vec3{0, 1, 1}));
  ExpectNear(wide.Generate({200, 100}, {}).direction, Normalize(Vec3{2, -1, 1}));
  const Camera tall(d, 100, 200);
  ExpectNear(tall.Generate({0, 100}, {}).direction, Normalize(Vec3{-1, 0, 1}));
  ExpectNear(tall.Generate({0, 0}, {}).direction, Normalize(Vec3{-1, 2, 1}));
}

TEST(Camera, FieldOfViewScalesByItsTangent) {
  CameraDescription d;
  d.fov = 60;
  ExpectNear(Camera(d, 100, 100).Generate({100, 50}, {}).direction, Normalize(Vec3{0.57735027f, 0, 1}));
}

TEST(Camera, ScreenWindowIsTakenAsGiven) {
  CameraDescription d;
  d.fov = 90;
  d.screen_window = {0, 1, -0.5f, 2};
  const Camera camera(d, 100, 100);
  ExpectNear(camera.Generate({0, 0}, {}).direction, Normalize(Vec3{0, 2, 1}));
  ExpectNear(camera.Generate({100, 100}, {}).direction, Normalize(Vec3{1, -0.5f, 1}));
}

TEST(Camera, TransformsIncludeMirrors) {
  CameraDescription d;
  d.fov = 90;
  d.camera_from_world = Transform::Scale({-1, 1, 1}) * Transform::LookAt({0, 2, 15}, {0, 2, 0}, {0, 1, 0});
  const Camera camera(d, 100, 100);
  const CameraRay ray = camera.Generate({100, 50}, {});
  ExpectNear(ray.origin, {0, 2, 15});
  // LookAt along -z has its x axis along -x in pbrt's left-handed space; the mirror turns it back.
  ExpectNear(ray.direction, Normalize(Vec3{1, 0, -1}));
}

TEST(Camera, LensRaysMeetOnThePlaneOfFocus) {
  CameraDescription d;
  d.fov = 50;
  d.lens_radius = 0.3f;
  d.focal_distance = 7;
  const Camera camera(d, 320, 200);
  CameraDescription pinhole = d;
  pinhole.lens_radius = 0;
  const CameraRay center = Camera(pinhole, 320, 200).Generate({250, 30}, {});
  const Vec3 focus = center.direction * (7 / center.direction.z);
  for (const Vec2 u : {Vec2{0.1f, 0.2f}, Vec2{0.9f, 0.5f}, Vec2{0.5f, 0.5f}, Vec2{0, 0.99f}}) {
    const CameraRay ray = camera.Generate({250, 30}, u);
    EXPECT_LE(Length(ray.origin), 0.3f * 1.00001f);
    EXPECT_NEAR(Length(ray.direction), 1, 1e-6);
    ExpectNear(ray.origin + ray.direction * ((7 - ray.origin.z) / ray.direction.z), focus, 2e-5f);
  }
  // Concentric map: the middle of the right edge goes to (1, 0).
  ExpectNear(camera.Generate({160, 100}, {1, 0.5f}).origin, {0.3f, 0, 0});
}

}  // namespace
}  // namespace lodestar
