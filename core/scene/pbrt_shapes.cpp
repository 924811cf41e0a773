#include <cmath>

#include "core/scene/pbrt_builder.h"

namespace lodestar {
namespace {

bool IsUnsupportedShape(std::string_view type) {
  for (std::string_view name :
       {"cone", "curve", "cylinder", "heightfield", "hyperboloid", "loopsubdiv", "nurbs", "paraboloid"})
    if (type == name) return true;
  return false;
}

SphereShape Sphere(PbrtParams& params) {
  SphereShape sphere;
  sphere.radius = params.PositiveFloat("radius", 1);
  if (params.Float("zmin", -sphere.radius) > -sphere.radius) params.Refuse({"zmin"}, "only whole spheres are");
  if (params.Float("zmax", sphere.radius) < sphere.radius) params.Refuse({"zmax"}, "only whole spheres are");
  params.RefuseUnless("phimax", {360}, "only whole spheres are");
  return sphere;
}

DiskShape Disk(PbrtParams& params) {
  DiskShape disk;
  disk.height = params.Float("height", 0);
  disk.radius = params.PositiveFloat("radius", 1);
  disk.inner_radius = params.NonNegativeFloat("innerradius", 0);
  if (!(disk.inner_radius < disk.radius))
    params.Fail(*params.Find("innerradius", {"float"}), "must be smaller than the radius");
  params.RefuseUnless("phimax", {360}, "only whole disks are");
  return disk;
}

// Normals and uvs come one a vertex, or not at all.
template <class Value>
void CheckCount(PbrtParams& params, std::string_view name, std::string_view type, const std::vector<Value>& values,
                size_t vertices) {
  if (!values.empty() && values.size() != vertices)
    params.Fail(*params.Find(name, {type}),
                "has " + std::to_string(values.size()) + " values for " + std::to_string(vertices) + " vertices");
}

}  // namespace

std::optional<TriangleMesh> PbrtBuilder::Triangles(PbrtParams& params) {
  TriangleMesh mesh;
  mesh.positions = params.Vec3s("P", "point3");
  if (mesh.positions.empty()) FailAt(params.where(), ErrorKind::kInvalidInput, params.label() + " needs \"point3 P\"");
  std::vector<uint32_t> indices = params.Indices("indices", mesh.positions.size());
  if (!params.Find("indices", {"integer"})) {
    if (mesh.positions.size() != 3)
      FailAt(params.where(), ErrorKind::kInvalidInput,
             params.label() + " needs \"integer indices\" (they may be left out for a single triangle)");
    indices = {0, 1, 2};
  }
  if (indices.empty() || indices.size() % 3 != 0)
    params.Fail(*params.Find("indices", {"integer"}),
                "takes three indices a triangle, not " + std::to_string(indices.size()) + " in all");
  for (size_t i = 0; i < indices.size(); i += 3) mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  mesh.normals = params.Vec3s("N", "normal");
  mesh.uvs = params.Vec2s("uv", "point2");
  CheckCount(params, "N", "normal", mesh.normals, mesh.positions.size());
  CheckCount(params, "uv", "point2", mesh.uvs, mesh.positions.size());
  params.Refuse({"S"}, "tangents come from the uvs");
  params.Accept({"faceIndices"});  // for ptex only
  return mesh;
}

std::optional<BilinearMesh> PbrtBuilder::Bilinear(PbrtParams& params) {
  BilinearMesh mesh;
  mesh.positions = params.Vec3s("P", "point3");
  if (mesh.positions.empty()) FailAt(params.where(), ErrorKind::kInvalidInput, params.label() + " needs \"point3 P\"");
  std::vector<uint32_t> indices = params.Indices("indices", mesh.positions.size());
  if (!params.Find("indices", {"integer"})) {
    if (mesh.positions.size() != 4)
      FailAt(params.where(), ErrorKind::kInvalidInput,
             params.label() + " needs \"integer indices\" (they may be left out for a single patch)");
    indices = {0, 1, 2, 3};
  }
  if (indices.empty() || indices.size() % 4 != 0)
    params.Fail(*params.Find("indices", {"integer"}),
                "takes four indices a patch, not " + std::to_string(indices.size()) + " in all");
  for (size_t i = 0; i < indices.size(); i += 4)
    mesh.patches.push_back({indices[i], indices[i + 1], indices[i + 2], indices[i + 3]});
  mesh.normals = params.Vec3s("N", "normal");
  mesh.uvs = params.Vec2s("uv", "point2");
  CheckCount(params, "N", "normal", mesh.normals, mesh.positions.size());
  CheckCount(params, "uv", "point2", mesh.uvs, mesh.positions.size());
  params.Refuse({"emissionfilename"}, "light from an image is not");
  params.Accept({"faceIndices"});
  return mesh;
}

void PbrtBuilder::Shape(const Token& directive) {
  InWorld(directive);
  const std::string type = NeedString("a shape's type");
  PbrtParams params = Params(directive, type, "shape");
  ShapeDescription shape;
  shape.where = directive.where();
  if (type == "trianglemesh") {
    shape.kind = *Triangles(params);
  } else if (type == "plymesh") {
    const PbrtParam* file = params.Find("filename", {"string"});
    if (!file) FailAt(directive.where(), ErrorKind::kInvalidInput, params.label() + " needs a \"string filename\"");
    shape.kind = PlyMesh{NeedFile(params, *file, params.String("filename", ""))};
    params.Refuse({"displacement"}, "surfaces are as their geometry is");
    params.Accept({"edgelength", "displacement.edgelength"});  // only matter with displacement
  } else if (type == "sphere") {
    shape.kind = Sphere(params);
  } else if (type == "disk") {
    shape.kind = Disk(params);
  } else if (type == "bilinearmesh") {
    shape.kind = *Bilinear(params);
  } else if (IsUnsupportedShape(type)) {
    return refusals_.Refuse(
        directive.where(),
        params.label() + " is not supported; use trianglemesh, plymesh, bilinearmesh, sphere or disk");
  } else {
    UnknownType(directive, type, "trianglemesh, plymesh, bilinearmesh, sphere, disk");
  }
  shape.alpha = FloatParam(params, "alpha", 1);
  if (shape.alpha.texture < 0 && !(shape.alpha.value >= 0 && shape.alpha.value <= 1))
    params.Fail(*params.Find("alpha", {"float"}), "must be between 0 and 1");
  params.Finish();
  AddShape(std::move(shape));
}

// Why light from the shape could not be sampled; null where it can.
const char* PbrtBuilder::CannotEmit(const ShapeDescription& shape) const {
  if (!std::holds_alternative<SphereShape>(shape.kind) && !std::holds_alternative<DiskShape>(shape.kind))
    return nullptr;
  float opacity = shape.alpha.value;
  if (shape.alpha.texture >= 0) {
    const auto* constant = std::get_if<ConstantTexture>(&scene_.textures[shape.alpha.texture].kind);
    if (!constant) return "with an alpha texture is not supported; use a triangle mesh";
    opacity = constant->value.r;
  }
  if (opacity > 0 && opacity < 1) return "with an opacity between 0 and 1 is not supported; scale its radiance instead";
  return nullptr;
}

void PbrtBuilder::AddShape(ShapeDescription shape) {
  shape.world_from_object = state_.ctm;
  shape.reverse_orientation = state_.reverse_orientation;
  if (state_.material < 0 && default_material_ < 0) {
    default_material_ = static_cast<int>(scene_.materials.size());
    scene_.materials.push_back({"", DiffuseMaterial{}, shape.where});
  }
  shape.material = state_.material >= 0 ? state_.material : default_material_;
  if (state_.area_light && current_object_ >= 0) {
    refusals_.Refuse(shape.where, "a shape that emits light (AreaLightSource at " +
                                      state_.area_light->where.ToString() +
                                      ") inside an object definition is not supported: lights cannot be instanced");
  } else if (const char* why = state_.area_light ? CannotEmit(shape) : nullptr) {
    refusals_.Refuse(shape.where, std::string("an area light on a sphere or disk ") + why);
  } else if (state_.area_light) {
    shape.light = state_.area_light;
  }
  (current_object_ >= 0 ? scene_.objects[current_object_].shapes : scene_.shapes).push_back(std::move(shape));
}

// ---- instances ----

void PbrtBuilder::ObjectBegin(const Token& directive) {
  InWorld(directive);
  const std::string name = NeedString("an object's name");
  if (current_object_ >= 0)
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "ObjectBegin inside the definition of \"" + scene_.objects[current_object_].name +
               "\"; definitions do not nest");
  if (!objects_.try_emplace(name, static_cast<int>(scene_.objects.size())).second)
    FailAt(directive.where(), ErrorKind::kInvalidInput, "an object \"" + name + "\" is defined already");
  Begin(directive);
  current_object_ = static_cast<int>(scene_.objects.size());
  scene_.objects.push_back({name, {}});
}

void PbrtBuilder::ObjectEnd(const Token& directive) {
  End(directive, "ObjectBegin");
  current_object_ = -1;
}

void PbrtBuilder::ObjectInstance(const Token& directive) {
  InWorld(directive);
  const std::string name = NeedString("an object's name");
  if (current_object_ >= 0)
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "ObjectInstance inside the definition of \"" + scene_.objects[current_object_].name +
               "\"; instances do not nest");
  const auto found = objects_.find(name);
  if (found == objects_.end())
    FailAt(directive.where(), ErrorKind::kInvalidInput, "no object \"" + name + "\" has been defined so far");
  scene_.instances.push_back({found->second, state_.ctm, directive.where()});
}

}  // namespace lodestar
