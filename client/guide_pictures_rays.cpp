#include "client/guide_pictures.h"
#include "core/guiding/guide_picture_space.h"

namespace lodestar {
namespace {

constexpr uint32_t kRays = 4096, kPixels = 512;
constexpr char kAxes[] = "XYZ";

}  // namespace

void DrawRays(const std::string& name, const std::string& title, const GuideView& view,
              const std::function<std::optional<Vec3>(float u_choice, Vec2 u)>& sample, PictureFolder* out) {
  const SurfaceInteraction& si = view.point->surface->si;
  const Bounds3 window = PictureWindow(view.bounds);
  const float far = 2 * Length(window.Diagonal());
  std::array<FloatGrid, 3> grids;
  for (int axis = 0; axis < 3; ++axis)
    grids[static_cast<size_t>(axis)] = EmptyPicture(window.Diagonal(), axis, kPixels);
  for (uint32_t i = 0; i < kRays; ++i) {
    Sampler sampler(0, i, 0, 0);
    const float u_choice = sampler.Next2D().x;
    const auto w = sample(u_choice, sampler.Next2D());
    if (!w) continue;
    const Ray ray{Scene::OffsetOrigin(si, *w), *w, kInfinity};
    Hit hit;
    const float t = view.scene->Intersect(ray, &hit) ? hit.t : far;
    for (int axis = 0; axis < 3; ++axis)
      AddSegment(ray.origin, ray.origin + *w * t, window, axis, &grids[static_cast<size_t>(axis)]);
  }
  for (int axis = 0; axis < 3; ++axis) {
    PictureStyle style;
    style.title = title + ", along " + kAxes[axis];
    style.caption = "of 4096 rays to the next surface.  right: " + std::string(1, kAxes[RightAxis(axis)]) +
                    ".  up: " + kAxes[UpAxis(axis)];
    out->Draw(name + "-" + static_cast<char>('x' + axis), grids[static_cast<size_t>(axis)], style);
  }
}

}  // namespace lodestar
