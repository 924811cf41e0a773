#include "client/guide_pictures.h"
#include "core/guiding/guide_picture_space.h"
#include "core/tracing/path_kernel.h"

namespace lodestar {
namespace {

constexpr uint32_t kPaths = 4096, kPixels = 512;
constexpr int kSegments = 3;
constexpr char kAxes[] = "XYZ";

struct Segment {
  Vec3 from, to;
  float light = 0;  // luminance that comes along it and that the first surface reflects
};

// No light samples: what comes along is what directions find. `far`: how long a segment is that leaves the scene.
std::vector<Segment> Follow(const Scene& scene, SurfaceHit at, const Technique& technique, float far,
                            Sampler& sampler) {
  std::vector<Segment> path;
  Rgb weight(1);
  while (path.size() < kSegments && !IsBlack(weight)) {
    const float u_choice = sampler.Next2D().x;
    const auto sample = technique(at, u_choice, sampler.Next2D());
    if (!sample) break;
    weight *= sample->weight;
    const float u_mix = sampler.Next2D().y;
    const Ray ray{Scene::OffsetOrigin(at.si, sample->w), sample->w, kInfinity};
    Hit hit;
    if (!scene.Intersect(ray, &hit)) {
      path.push_back({ray.origin, ray.origin + ray.direction * far,
                      Luminance(weight * scene.Environment(ray.direction).radiance)});
      break;
    }
    at.si = scene.Interaction(hit);
    at.bsdf = scene.BsdfAt(at.si, u_mix);
    const Rgb emitted = at.si.light >= 0 ? scene.Emitted(at.si, -ray.direction) : Rgb();
    path.push_back({ray.origin, at.si.p, Luminance(weight * emitted)});
    at.wo = at.si.shading.ToLocal(-ray.direction);
  }
  for (size_t i = path.size(); i-- > 1;) path[i - 1].light += path[i].light;
  return path;
}

}  // namespace

void DrawRays(const std::string& name, const std::string& title, const GuideView& view, const Technique& technique,
              PictureFolder* out) {
  const Bounds3 window = PictureWindow(view.bounds);
  const float far = 2 * Length(window.Diagonal());
  std::array<FloatGrid, 3> counts, lights;
  for (int axis = 0; axis < 3; ++axis)
    counts[static_cast<size_t>(axis)] = lights[static_cast<size_t>(axis)] =
        EmptyPicture(window.Diagonal(), axis, kPixels);
  for (uint32_t i = 0; i < kPaths; ++i) {
    Sampler sampler(0, i, 0, 0);
    for (const auto& [from, to, light] : Follow(*view.scene, *view.point->surface, technique, far, sampler)) {
      for (int axis = 0; axis < 3; ++axis) {
        AddSegment(from, to, 1, window, axis, &counts[static_cast<size_t>(axis)]);
        AddSegment(from, to, light / kPaths, window, axis, &lights[static_cast<size_t>(axis)]);
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::string letter(1, static_cast<char>('x' + axis)),
        sides = ".  right: " + std::string(1, kAxes[RightAxis(axis)]) + ".  up: " + kAxes[UpAxis(axis)];
    PictureStyle style;
    style.title = title + ", along " + kAxes[axis];
    style.caption = "of 4096 paths of three segments" + sides;
    out->Draw(name + "-" + letter, counts[static_cast<size_t>(axis)], style);
    style.title = title + ", by their light, along " + kAxes[axis];
    style.caption = "of the radiance reflected here" + sides;
    out->Draw(name + "-light-" + letter, lights[static_cast<size_t>(axis)], style);
  }
}

}  // namespace lodestar
