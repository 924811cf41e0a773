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
    const Vec3 from = Scene::OffsetOrigin(at.si, sample->w);
    Ray ray{from, sample->w, kInfinity};
    Hit hit;
    Rgb emitted;
    bool met = false, left = false;
    for (int passed = 0; !met && passed <= kMostInterfaces; ++passed) {
      left = !scene.Intersect(ray, &hit);
      if (left) break;
      at.si = scene.Interaction(ray, hit);
      if (at.si.light >= 0) emitted += scene.Emitted(at.si, -ray.direction);
      at.bsdf = scene.BsdfAt(at.si, u_mix);
      met = at.bsdf.kind() != Bsdf::Kind::kNone;
      ray.origin = Scene::OffsetOrigin(at.si, ray.direction);
    }
    if (left) emitted += scene.Environment(ray.direction).radiance;
    path.push_back({from, met ? at.si.p : from + ray.direction * far, Luminance(weight * emitted)});
    if (!met) break;
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
