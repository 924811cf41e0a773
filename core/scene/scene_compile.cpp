#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/overloaded.h"
#include "core/image/image.h"
#include "core/math/elementary.h"
#include "core/scene/scene_parts.h"

namespace lodestar {
namespace {

[[noreturn]] void Fail(const SourceLocation& where, const std::string& why) {
  throw Error(ErrorKind::kInvalidInput, where.ToString() + ": " + why);
}

void CheckEmission(Rgb value, const SourceLocation& where) {
  if (!IsFinite(value) || MinComponent(value) < 0) Fail(where, "a light's emission must be finite and not negative");
}

double MaxAbs(const std::array<double, 3>& v) {
  return std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
}

Instance MakeInstance(uint32_t group, const Transform& transform) {
  Instance instance;
  instance.group = group;
  instance.world_from_group = Affine::From(transform.matrix());
  instance.group_from_world = Affine::From(transform.inverse_matrix());
  const auto& m = instance.world_from_group.m;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row)
      instance.embree_transform[column * 3 + row] = static_cast<float>(m[row * 4 + column]);
  // The Frobenius norm bounds the stretch.
  double sum = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) sum += m[row * 4 + column] * m[row * 4 + column];
  instance.stretch = static_cast<float>(std::sqrt(sum));
  const auto& inverse = instance.group_from_world.m;
  instance.ray_error = static_cast<float>(std::sqrt(sum) * MaxAbs({inverse[3], inverse[7], inverse[11]})) * 4 * kRound;
  return instance;
}

}  // namespace

void CompileGeometry(const SceneDescription& description, SceneParts* parts) {
  ShapeCompiler compiler(description, parts);
  parts->groups.resize(1);
  for (const auto& shape : description.shapes) compiler.Add(shape, shape.world_from_object, &parts->groups[0], false);

  // An object used once joins the world's own tree: an instance would cost every ray that passes its box a second
  // traversal.
  std::vector<int> uses(description.objects.size(), 0);
  for (const auto& instance : description.instances) {
    if (instance.object < 0 || instance.object >= static_cast<int>(uses.size()))
      Fail(instance.where, "the instance names an object that does not exist");
    if (!instance.world_from_instance.Invertible())
      Fail(instance.where, "the instance's transform flattens it to nothing (its matrix is singular)");
    ++uses[instance.object];
  }
  std::vector<uint32_t> group_of(description.objects.size(), 0);
  for (size_t i = 0; i < uses.size(); ++i) {
    if (uses[i] < 2) continue;
    GeometryGroup group;
    for (const auto& shape : description.objects[i].shapes) compiler.Add(shape, shape.world_from_object, &group, true);
    group_of[i] = static_cast<uint32_t>(parts->groups.size());
    parts->groups.push_back(std::move(group));
  }
  for (const auto& use : description.instances) {
    if (uses[use.object] < 2) {
      for (const auto& shape : description.objects[use.object].shapes)
        compiler.Add(shape, use.world_from_instance * shape.world_from_object, &parts->groups[0], true);
      continue;
    }
    const uint32_t group = group_of[use.object];
    if (parts->groups[group].empty()) continue;
    parts->instances.push_back(MakeInstance(group, use.world_from_instance));
    const Bounds3 bounds = use.world_from_instance.Bounds(parts->groups[group].bounds);
    if (!WithinReach(bounds.min) || !WithinReach(bounds.max))
      Fail(use.where, std::string("the instance") + kOutOfReach);
    parts->groups[0].bounds.Extend(bounds);
  }
  parts->accelerator =
      std::make_unique<Accelerator>(parts->groups, parts->instances, parts->textures, parts->materials);
}

void CompileLights(const SceneDescription& description, SceneParts* parts) {
  for (const auto& light : description.lights) {
    std::visit(Overloaded{
                   [&](const PointLight& l) {
                     CheckEmission(l.intensity, light.where);
                     parts->lights.AddPoint(l);
                   },
                   [&](const SpotLight& l) {
                     CheckEmission(l.intensity, light.where);
                     if (l.from == l.to)
                       Fail(light.where, "a spot light needs \"from\" and \"to\" at different places");
                     parts->lights.AddSpot(l);
                   },
                   [&](const DistantLight& l) {
                     CheckEmission(l.radiance, light.where);
                     if (!(LengthSquared(l.to_light) > 0))
                       Fail(light.where, "a distant light needs \"from\" and \"to\" at different places");
                     parts->lights.AddDistant(l);
                   },
                   [&](const InfiniteLight& l) {
                     CheckEmission(l.radiance, light.where);
                     if (l.path.empty()) {
                       parts->lights.AddEnvironment(EnvironmentLight(l.radiance));
                       return;
                     }
                     FloatImage image;
                     try {
                       image = ReadImage(l.path);
                     } catch (const Error& e) {
                       throw Error(e.kind(), light.where.ToString() + ": " + e.what());
                     }
                     if (image.width != image.height)
                       Fail(light.where, "environment image '" + l.path + "' is " + std::to_string(image.width) +
                                             " x " + std::to_string(image.height) +
                                             "; an equal-area octahedral image is square (imgtool makeequiarea "
                                             "converts a latitude-longitude one)");
                     for (Rgb& p : image.pixels) {
                       if (!IsFinite(p))
                         Fail(light.where, "environment image '" + l.path + "' holds values that are not finite");
                       p = Rgb(std::max(p.r, 0.0f), std::max(p.g, 0.0f), std::max(p.b, 0.0f)) * l.radiance;
                     }
                     if (l.illuminance > 0) {
                       const float now =
                           Luminance(IrradianceFromAbove(image.pixels, image.width)) / Luminance(l.radiance);
                       if (!(now > 0))
                         Fail(light.where, "\"illuminance\" needs light from above, and environment image '" + l.path +
                                               "' has none (or \"scale\" is 0)");
                       for (Rgb& p : image.pixels) p = p * (l.illuminance / now);
                     }
                     parts->lights.AddEnvironment(EnvironmentLight(image.pixels, image.width, light.world_from_light));
                   },
               },
               light.kind);
  }
  parts->lights.Finish(parts->groups[0].bounds);
}

SceneNeeds FindNeeds(const SceneDescription& description, const SceneParts& parts) {
  SceneNeeds needs;
  needs.smooth_lobes = false;
  const auto visit = [&](const MeshRecord& record) {
    const auto& t = parts.materials.traits(record.material);
    needs.textures |= t.textured;
    needs.delta_lobes |= t.delta;
    needs.smooth_lobes |= t.smooth;
    needs.transmission |= t.transmission;
    needs.mix |= t.mix;
    needs.alpha |= (record.flags & MeshRecord::kHasAlpha) != 0;
  };
  for (const auto& group : parts.groups) {
    for (const auto& mesh : group.meshes) visit(mesh);
    for (const auto& q : group.spheres) visit(q.record);
    for (const auto& q : group.disks) visit(q.record);
    needs.quadrics |= !group.spheres.empty() || !group.disks.empty();
  }
  needs.environment = parts.lights.has_environment();
  needs.area_lights = parts.lights.has_area_lights();
  needs.unseen_lights = parts.lights.has_unseen_lights();
  needs.instances = !parts.instances.empty();
  needs.lens = description.camera.lens_radius > 0;
  return needs;
}

std::string SceneNeeds::ToString() const {
  std::string text;
  const auto add = [&text](bool needed, const char* name) {
    if (needed) text += (text.empty() ? "" : " ") + std::string(name);
  };
  add(textures, "textures");
  add(alpha, "alpha");
  add(environment, "environment");
  add(delta_lobes, "delta-lobes");
  add(smooth_lobes, "smooth-lobes");
  add(transmission, "transmission");
  add(area_lights, "area-lights");
  add(unseen_lights, "unseen-lights");
  add(mix, "mix");
  add(instances, "instances");
  add(quadrics, "quadrics");
  add(lens, "lens");
  return text.empty() ? "nothing" : text;
}

std::string SceneNeeds::NotNeeded() const {
  struct Part {
    bool needed;
    const char* name;
  };
  std::string text;
  const auto add = [&text](std::initializer_list<Part> parts, const char* left_out_of) {
    std::string names;
    for (const Part& part : parts) {
      if (!part.needed) names += (names.empty() ? "" : ", ") + std::string(part.name);
    }
    if (!names.empty()) text += (text.empty() ? "" : "; ") + names + " (left out of " + left_out_of + ")";
  };
  add({{environment, "environment"}, {BsdfsAtHits(), "textures and mixes"}, {delta_lobes, "delta lobes"}},
      "the path kernel");
  add({{alpha, "alpha"}, {instances, "instances"}, {quadrics, "quadrics"}}, "the intersector");
  add({{lens, "lens"}}, "camera rays");
  add({{Lights(), "light samples"}}, "all paths");
  add({{Guidable(), "guiding"}}, "method 'auto'");
  return text.empty() ? "nothing" : text;
}

}  // namespace lodestar
