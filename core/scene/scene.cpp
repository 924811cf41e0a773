#include "core/scene/scene.h"

#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/picture_size.h"
#include "core/scene/scene_parts.h"

namespace lodestar {

struct Scene::Impl : SceneParts {};

Scene::Scene() : impl_(std::make_unique<Impl>()) {}
Scene::~Scene() = default;

std::shared_ptr<const Scene> Scene::Compile(const SceneDescription& description) {
  std::shared_ptr<Scene> scene(new Scene());
  SceneParts& parts = *scene->impl_;
  scene->resolution_x_ = description.resolution_x;
  scene->resolution_y_ = description.resolution_y;
  if (!CanBeRendered(scene->resolution_x_, scene->resolution_y_))
    throw Error(ErrorKind::kInvalidInput, "the image is " + std::to_string(scene->resolution_x_) + " x " +
                                              std::to_string(scene->resolution_y_) + " pixels; " + PictureSizeRule());
  const CameraDescription& camera = description.camera;
  if (!(camera.fov > 0 && camera.fov < 180) || !camera.camera_from_world.Invertible() || !(camera.lens_radius >= 0) ||
      !(camera.focal_distance > 0))
    throw Error(
        ErrorKind::kInvalidInput,
        "the camera needs a field of view between 0 and 180 degrees, an invertible transform, a lens radius of at "
        "least 0 and a positive focal distance");

  parts.textures = TextureTable(description.textures);
  parts.materials = MaterialTable(description.materials, parts.textures);
  CompileGeometry(description, &parts);
  CompileLights(description, &parts);

  scene->camera_ = std::make_unique<Camera>(camera, scene->resolution_x_, scene->resolution_y_);
  scene->bounds_ = parts.groups[0].bounds;
  scene->needs_ = FindNeeds(description, parts);
  scene->filter_ = description.filter;
  scene->max_depth_ = description.max_depth;
  scene->hash_ = HashScene(description, parts);
  scene->memory_bytes_ = parts.textures.memory_bytes() + parts.materials.memory_bytes() + parts.lights.memory_bytes() +
                         parts.accelerator->memory_bytes();
  for (const auto& group : parts.groups) {
    scene->triangle_count_ += group.triangles[0].size() + group.triangles[1].size();
    scene->dropped_triangles_ += group.dropped_triangles;
    scene->memory_bytes_ += group.memory_bytes();
  }
  if (scene->dropped_triangles_ > 0) spdlog::info("left out {} triangles without area", scene->dropped_triangles_);
  return scene;
}

bool Scene::Intersect(const Ray& ray, Hit* hit) const {
  return impl_->accelerator->Intersect(ray, hit);
}
bool Scene::Unoccluded(const Ray& ray) const {
  return impl_->accelerator->Unoccluded(ray);
}

Bsdf Scene::BsdfAt(const SurfaceInteraction& si, float u_mix) const {
  return impl_->materials.At(si.material, si.uv, u_mix);
}
const Bsdf& Scene::ReadyBsdf(const SurfaceInteraction& si) const {
  return impl_->materials.Ready(si.material);
}

bool Scene::has_lights() const {
  return !impl_->lights.empty();
}
std::optional<LightSample> Scene::SampleLight(Vec3 p, double u_pick, Vec2 u, LightGroupWeights weights) const {
  return impl_->lights.Sample(impl_->textures, p, u_pick, u, weights);
}
std::optional<LightSample> Scene::SampleUnseenLight(Vec3 p, double u_pick, Vec2 u) const {
  return impl_->lights.SampleUnseen(impl_->textures, p, u_pick, u);
}
Rgb Scene::Emitted(const SurfaceInteraction& si, Vec3 wo_world) const {
  return si.light < 0 ? Rgb() : impl_->lights.Emitted(si.light, si.ng, wo_world);
}
float Scene::LightPdf(Vec3 from, const SurfaceInteraction& si) const {
  return si.light < 0 ? 0 : impl_->lights.Pdf(from, si);
}
EnvironmentSample Scene::Environment(Vec3 wi) const {
  return impl_->lights.Environment(wi);
}
const std::vector<float>& Scene::light_groups() const {
  return impl_->lights.groups().shares();
}
float Scene::LightRatio(LightGroupWeights weights, int32_t light) const {
  return impl_->lights.groups().Ratio(weights, impl_->lights.groups().group(static_cast<size_t>(light)));
}
float Scene::EnvironmentRatio(LightGroupWeights weights) const {
  return impl_->lights.groups().Ratio(weights, LightGroups::kEnvironments);
}

SurfaceInteraction Scene::Interaction(const Hit& hit) const {
  return Interact(*impl_, hit);
}

}  // namespace lodestar
