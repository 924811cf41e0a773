// The scene's identity: a hash of everything that determines its picture, as compiled where that is flat arrays, as
// described elsewhere.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/base/overloaded.h"
#include "core/scene/scene_parts.h"

namespace lodestar {
namespace {

class Hasher {
 public:
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void operator()(T v) { bytes_.Put(v); }
  void operator()(Vec3 v) { Floats({v.x, v.y, v.z}); }
  void operator()(Rgb v) { Floats({v.r, v.g, v.b}); }
  void operator()(const RgbValue& v) {
    (*this)(v.value);
    (*this)(v.texture);
  }
  void operator()(const FloatValue& v) {
    (*this)(v.value);
    (*this)(v.texture);
  }
  void operator()(const UvMapping& m) { Floats({m.su, m.sv, m.du, m.dv}); }
  void operator()(const Transform& t) {
    for (const auto& row : t.matrix())
      for (const double v : row) (*this)(v);
  }
  void operator()(const Affine& a) {
    for (const double v : a.m) (*this)(v);
  }
  void operator()(const Roughness& r) {
    (*this)(r.u);
    (*this)(r.v);
    (*this)(r.remap);
  }
  // Large arrays go in as their own hash, so that the document stays small.
  template <class Values>
  void Array(const Values& values) {
    (*this)(uint64_t{values.size()});
    bytes_.PutString(Sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])}).hex);
  }
  void File(const std::string& path) {
    auto [entry, fresh] = files_.try_emplace(path);
    if (fresh) {
      std::ifstream in(path, std::ios::binary);
      if (!in) throw Error(ErrorKind::kNotFound, "cannot read '" + path + "'");
      const std::string content{std::istreambuf_iterator<char>(in), {}};
      entry->second = Sha256(content).hex;
    }
    bytes_.PutString(entry->second);
  }
  ContentHash Finish() { return Sha256(bytes_.bytes()); }

 private:
  void Floats(std::initializer_list<float> values) {
    for (const float v : values) (*this)(v);
  }
  ByteWriter bytes_;
  std::map<std::string, std::string> files_;
};

void HashTexture(const TextureDescription& texture, Hasher& put) {
  put(texture.is_float);
  put(texture.kind.index());
  std::visit(Overloaded{
                 [&](const ConstantTexture& t) { put(t.value); },
                 [&](const ImageTexture& t) {
                   put.File(t.path);
                   put(t.wrap);
                   put(t.filter);
                   put(t.encoding);
                   put(t.gamma);
                   put(t.scale);
                   put(t.invert);
                   put(t.mapping);
                 },
                 [&](const ScaleTexture& t) {
                   put(t.tex);
                   put(t.scale);
                 },
                 [&](const MixTexture& t) {
                   put(t.a);
                   put(t.b);
                   put(t.amount);
                 },
                 [&](const CheckerboardTexture& t) {
                   put(t.a);
                   put(t.b);
                   put(t.mapping);
                 },
             },
             texture.kind);
}

void HashMaterial(const MaterialDescription& material, Hasher& put) {
  const auto conductor = [&put](const ConductorMaterial& m) {
    put(m.eta);
    put(m.k);
    put(m.has_reflectance);
    put(m.reflectance);
    put(m.roughness);
  };
  put(material.kind.index());
  std::visit(Overloaded{
                 [&](const DiffuseMaterial& m) { put(m.reflectance); },
                 conductor,
                 [&](const DielectricMaterial& m) {
                   put(m.eta);
                   put(m.roughness);
                 },
                 [&](const ThinDielectricMaterial& m) { put(m.eta); },
                 [&](const CoatedDiffuseMaterial& m) {
                   put(m.reflectance);
                   put(m.eta);
                   put(m.roughness);
                 },
                 [&](const CoatedConductorMaterial& m) {
                   put(m.interface_eta);
                   put(m.interface_roughness);
                   conductor(m.conductor);
                 },
                 [&](const DiffuseTransmissionMaterial& m) {
                   put(m.reflectance);
                   put(m.transmittance);
                   put(m.scale);
                 },
                 [&](const MixMaterial& m) {
                   put(m.a);
                   put(m.b);
                   put(m.amount);
                 },
                 [&](const InterfaceMaterial&) {},
             },
             material.kind);
}

void HashLight(const LightDescription& light, Hasher& put) {
  put(light.kind.index());
  std::visit(Overloaded{
                 [&](const PointLight& l) {
                   put(l.intensity);
                   put(l.from);
                 },
                 [&](const SpotLight& l) {
                   put(l.intensity);
                   put(l.from);
                   put(l.to);
                   put(l.cone_angle);
                   put(l.cone_delta);
                 },
                 [&](const DistantLight& l) {
                   put(l.radiance);
                   put(l.to_light);
                 },
                 [&](const InfiniteLight& l) {
                   put(l.radiance);
                   put(!l.path.empty());
                   put(l.illuminance);
                   if (!l.path.empty()) put.File(l.path);
                   put(light.world_from_light);
                 },
             },
             light.kind);
}

void HashRecord(const MeshRecord& record, Hasher& put) {
  put(record.flags);
  put(record.material);
  put(record.first_light);
  put(record.first_triangle);
  put(record.alpha);
}

void HashQuadric(const Quadric& q, Hasher& put) {
  put(q.group_from_object);
  put(q.radius);
  put(q.inner_radius);
  put(q.height);
  put(q.reverse);
  HashRecord(q.record, put);
}

void HashEmission(const ShapeDescription& shape, Hasher& put) {
  put(shape.light.has_value());
  if (!shape.light) return;
  put(shape.light->radiance);
  put(shape.light->two_sided);
  put(shape.light->power);
  put(shape.alpha);
  put(shape.world_from_object);  // of shapes that are lights only, which the groups do not hold
  std::visit(Overloaded{
                 [&](const TriangleMesh& m) {
                   put.Array(m.positions);
                   put.Array(m.triangles);
                 },
                 [&](const PlyMesh& m) { put.File(m.path); },
                 [&](const SphereShape& s) { put(s.radius); },
                 [&](const DiskShape& d) {
                   put(d.radius);
                   put(d.inner_radius);
                   put(d.height);
                 },
                 [&](const BilinearMesh& m) {
                   put.Array(m.positions);
                   put.Array(m.patches);
                 },
             },
             shape.kind);
}

}  // namespace

ContentHash HashScene(const SceneDescription& description, const SceneParts& parts) {
  Hasher put;
  put(uint32_t{1});  // version of this document
  for (const auto& group : parts.groups) {
    put.Array(group.vertices);
    for (const auto& triangles : group.triangles) put.Array(triangles);
    put(uint64_t{group.meshes.size()});
    for (const auto& record : group.meshes) HashRecord(record, put);
    for (const auto* quadrics : {&group.spheres, &group.disks}) {
      put(uint64_t{quadrics->size()});
      for (const auto& q : *quadrics) HashQuadric(q, put);
    }
  }
  put(uint64_t{parts.instances.size()});
  for (const auto& instance : parts.instances) {
    put(instance.group);
    put(instance.world_from_group);
  }
  for (const auto& shape : description.shapes) HashEmission(shape, put);
  put(uint64_t{description.textures.size()});
  for (const auto& texture : description.textures) HashTexture(texture, put);
  put(uint64_t{description.materials.size()});
  for (const auto& material : description.materials) HashMaterial(material, put);
  put(uint64_t{description.lights.size()});
  for (const auto& light : description.lights) HashLight(light, put);
  const CameraDescription& camera = description.camera;
  put(camera.camera_from_world);
  put(camera.fov);
  for (const float edge : camera.screen_window) put(edge);
  put(camera.lens_radius);
  put(camera.focal_distance);
  put(description.resolution_x);
  put(description.resolution_y);
  const PixelFilterDescription& filter = description.filter;
  put(filter.kind);
  put(filter.radius_x);
  put(filter.radius_y);
  put(filter.sigma);
  put(filter.b);
  put(filter.c);
  put(description.max_depth);
  return put.Finish();
}

}  // namespace lodestar
