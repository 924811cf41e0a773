#include "client/guide_pictures.h"
#include "client/values.h"
#include "core/guiding/focal_projection.h"
#include "core/guiding/guide_picture_space.h"

namespace lodestar {
namespace {

constexpr uint32_t kProjectionPixels = 512;
constexpr char kAxes[] = "XYZ";

struct Kind {
  FocalProjection projection;
  const char *name, *title;
};
constexpr Kind kKinds[] = {{FocalProjection::kMaximum, "max", "greatest density"},
                           {FocalProjection::kAverage, "mean", "mean density"}};

std::string NameOf(const FocalField& field, size_t octree) {
  return field.octrees().size() == 1 ? "focal-" : octree == 0 ? "converging-" : "diverging-";
}

void DrawAxes(const FocalField& field, size_t octree, const GuideView& view, PictureFolder* out) {
  for (const Kind& kind : kKinds) {
    for (int axis = 0; axis < 3; ++axis) {
      const FloatGrid grid = ProjectAlong(field, octree, kind.projection, axis, kProjectionPixels);
      PictureStyle style;
      style.title = std::string(kind.title) + " along " + kAxes[axis];
      style.caption =
          std::string("times the box's mean.  right: ") + kAxes[RightAxis(axis)] + ".  up: " + kAxes[UpAxis(axis)];
      style.scale = view.density_scale;
      if (view.point) {
        const Vec3 at = field.ToUnit(view.point->p);
        style.marker = {at[RightAxis(axis)] * static_cast<float>(grid.width),
                        (1 - at[UpAxis(axis)]) * static_cast<float>(grid.height)};
      }
      out->Draw(NameOf(field, octree) + kind.name + "-" + static_cast<char>('x' + axis), grid, style);
    }
  }
}

// Along whole camera rays, not only up to the first surface: what lies behind it matters as much. The scene is blended
// in as if lit from the camera.
void DrawCamera(const FocalField& field, size_t octree, const GuideView& view, PictureFolder* out) {
  const Scene& scene = *view.scene;
  const auto full_width = static_cast<uint32_t>(scene.resolution_x()),
             full_height = static_cast<uint32_t>(scene.resolution_y());
  const uint32_t step = std::max(1u, (std::max(full_width, full_height) + kProjectionPixels - 1) / kProjectionPixels);
  const uint32_t width = std::max(1u, full_width / step), height = std::max(1u, full_height / step);
  const auto camera_ray = [&](uint32_t x, uint32_t y) {
    const float s = static_cast<float>(step);
    return scene.camera().Generate({(static_cast<float>(x) + 0.5f) * s, (static_cast<float>(y) + 0.5f) * s},
                                   {0.5f, 0.5f});
  };
  std::vector<float> shade(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      Sampler sampler(0, x, y, 0);
      if (const auto hit = FirstSurface(scene, camera_ray(x, y), sampler))
        shade[size_t{y} * width + x] = 0.1f + 0.9f * std::fabs(hit->wo.z);
    }
  }
  for (const Kind& kind : kKinds) {
    PictureStyle style;
    style.title = std::string(kind.title) + " from the camera";
    style.caption = "times the box's mean, along whole rays; the scene blended in";
    style.scale = view.density_scale;
    style.shade = shade;
    const FloatGrid grid = Project(field, octree, kind.projection, width, height, [&](uint32_t x, uint32_t y) {
      const CameraRay ray = camera_ray(x, y);
      return FocalPixelRay{ray.origin, ray.direction};
    });
    out->Draw(NameOf(field, octree) + kind.name + "-camera", grid, style);
  }
}

}  // namespace

void DrawFocal(const FocalField& field, const GuideView& view, PictureFolder* out) {
  for (size_t octree = 0; octree < field.octrees().size(); ++octree) {
    DrawAxes(field, octree, view, out);
    if (view.scene) DrawCamera(field, octree, view, out);
  }
  if (!view.point) return;
  const Vec3 p = view.point->p;
  out->DrawDensity("guide",
                   "guided directions at " + FormatNumber(p.x) + ", " + FormatNumber(p.y) + ", " + FormatNumber(p.z),
                   [&](Vec3 w) { return field.Pdf(p, w); });
}

}  // namespace lodestar
