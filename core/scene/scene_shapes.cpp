#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/overloaded.h"
#include "core/scene/ply.h"
#include "core/scene/scene_parts.h"

namespace lodestar {
namespace {

[[noreturn]] void Fail(ErrorKind kind, const SourceLocation& where, const std::string& why) {
  throw Error(kind, where.ToString() + ": " + why);
}

// The emission's radiance times what gives `power` watts (luminous, Y) at luminance 1 from the whole light, of this
// area.
Rgb RadianceOfPower(const LightTable::Emission& emission, float power, double area) {
  return emission.radiance * static_cast<float>(power / (double(kPi) * area * (emission.two_sided ? 2 : 1)));
}

}  // namespace

// A shape's attributes, resolved.
struct ShapeCompiler::Surface {
  const ShapeDescription& shape;
  const Transform& transform;
  bool swaps = false;
  bool invisible = false;  // an opacity of zero
  uint32_t flags = 0;
  FloatValue alpha;
  std::optional<LightTable::Emission> emission;
  uint32_t slot() const { return flags & MeshRecord::kHasAlpha ? kFilteredTriangles : kOpaqueTriangles; }
};

void ShapeCompiler::Add(const ShapeDescription& shape, const Transform& transform, GeometryGroup* group,
                        bool in_object) {
  if (shape.material < 0 || shape.material >= static_cast<int>(description_.materials.size()))
    Fail(ErrorKind::kInvalidInput, shape.where, "the shape's material does not exist");
  if (!transform.Invertible())
    Fail(ErrorKind::kInvalidInput, shape.where,
         "the shape's transform flattens it to nothing (its matrix is singular)");
  if (in_object && shape.light)
    Fail(ErrorKind::kUnsupported, shape.light->where,
         "area lights inside object definitions are not supported; take the shape out of ObjectBegin/ObjectEnd");

  const auto& traits = parts_.materials.traits(shape.material);
  Surface surface{shape, transform, transform.SwapsHandedness(), false, 0, {}, {}};
  surface.alpha = parts_.textures.Fold(shape.alpha);
  surface.invisible = surface.alpha.texture < 0 && !(surface.alpha.value > 0);
  if (surface.alpha.texture >= 0 || surface.alpha.value < 1 || traits.contains_interface)
    surface.flags |= MeshRecord::kHasAlpha;
  if (traits.needs_uv) surface.flags |= MeshRecord::kNeedsUv;
  if (traits.needs_tangent) surface.flags |= MeshRecord::kNeedsTangent;
  if (shape.light && !IsBlack(shape.light->radiance)) {
    if (!IsFinite(shape.light->radiance) || MinComponent(shape.light->radiance) < 0)
      Fail(ErrorKind::kInvalidInput, shape.light->where, "an area light's radiance must be finite and not negative");
    if (traits.interface_only || traits.contains_interface)
      Fail(ErrorKind::kUnsupported, shape.light->where,
           "a light on the material \"interface\", or on a mix with it, is not supported: there is no surface to give "
           "it");
    surface.emission =
        LightTable::Emission{shape.light->radiance, shape.light->two_sided, surface.invisible, surface.alpha};
    surface.flags |= MeshRecord::kEmissive;
  }
  // What neither scatters nor emits, or is wholly transparent and dark, is not there.
  if (!surface.emission && (traits.interface_only || surface.invisible)) return;

  const auto quadric = [&](double radius, double inner, double height) {
    if (!(radius > 0) || !(inner >= 0 && inner < radius) || !std::isfinite(radius) || !std::isfinite(height))
      Fail(ErrorKind::kInvalidInput, shape.where,
           "a radius must be positive and finite, and an inner radius smaller than the outer");
    Quadric q;
    q.group_from_object = Affine::From(transform.matrix());
    q.object_from_group = Affine::From(transform.inverse_matrix());
    q.radius = radius;
    q.inner_radius = inner;
    q.height = height;
    q.reverse = shape.reverse_orientation;
    return q;
  };
  std::visit(
      Overloaded{
          [&](const TriangleMesh& mesh) { AddMesh(mesh, surface, group); },
          [&](const PlyMesh& ply) {
            try {
              AddMesh(ReadPly(ply.path), surface, group);
            } catch (const Error& e) {
              const std::string text = e.what(), place = shape.where.ToString();
              throw Error(e.kind(), text.starts_with(place) ? text : place + ": " + text);
            }
          },
          [&](const SphereShape& s) { AddQuadric(quadric(s.radius, 0, 0), true, surface, group); },
          [&](const DiskShape& d) { AddQuadric(quadric(d.radius, d.inner_radius, d.height), false, surface, group); },
          [&](const BilinearMesh& mesh) { AddMesh(Tessellate(mesh, surface), surface, group); },
      },
      shape.kind);
}

void ShapeCompiler::AddMesh(const TriangleMesh& mesh, const Surface& surface, GeometryGroup* group) {
  const SourceLocation& where = surface.shape.where;
  const bool reverse = surface.shape.reverse_orientation;
  const size_t count = mesh.positions.size();
  if (!mesh.normals.empty() && mesh.normals.size() != count)
    Fail(ErrorKind::kInvalidInput, where, "the mesh has another number of normals than of vertices");
  if (!mesh.uvs.empty() && mesh.uvs.size() != count)
    Fail(ErrorKind::kInvalidInput, where, "the mesh has another number of uvs than of vertices");
  if (group->vertices.size() + count >= (size_t{1} << 32))
    Fail(ErrorKind::kUnsupported, where, "more than 2^32 vertices in one scene");

  MeshRecord record;
  record.flags = surface.flags;
  record.material = static_cast<uint32_t>(surface.shape.material);
  record.alpha = surface.alpha;
  if (!mesh.normals.empty()) record.flags |= MeshRecord::kHasNormals;
  if (!mesh.uvs.empty()) record.flags |= MeshRecord::kHasUvs;
  if (mesh.normals.empty() && reverse != surface.swaps) record.flags |= MeshRecord::kFlip;

  // 1. Vertices into the group's space. Normals share one scale, which keeps their relative weights in the
  // interpolation.
  const auto base = static_cast<uint32_t>(group->vertices.size());
  std::vector<Vertex> vertices(count);
  float longest = 0;
  for (size_t i = 0; i < count; ++i) {
    Vertex& v = vertices[i];
    v.p = surface.transform.Point(mesh.positions[i]);
    if (!WithinReach(v.p)) Fail(ErrorKind::kInvalidInput, where, "vertex " + std::to_string(i) + kOutOfReach);
    if (!mesh.uvs.empty()) {
      v.u = mesh.uvs[i].x;
      v.v = mesh.uvs[i].y;
      if (!std::isfinite(v.u) || !std::isfinite(v.v)) v.u = v.v = 0;
    }
    if (!mesh.normals.empty()) {
      v.n = surface.transform.Normal(mesh.normals[i]);
      if (reverse) v.n = -v.n;
      if (!IsFinite(v.n)) v.n = {};  // zero: the geometric normal stands in
      longest = std::max(longest, MaxComponent(Abs(v.n)));
    }
  }
  for (Vertex& v : vertices)
    if (longest > 0) v.n *= 1 / longest;

  // 2. Triangles that have an area in floats.
  const uint32_t slot = surface.slot();
  auto& triangles = group->triangles[slot];
  record.first_triangle = static_cast<uint32_t>(triangles.size());
  std::vector<LightTriangle> emitters;
  std::vector<LightTable::TriangleUvs> emitter_uvs;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& corner = mesh.triangles[i];
    for (const uint32_t index : corner)
      if (index >= count)
        Fail(ErrorKind::kInvalidInput, where,
             "triangle " + std::to_string(i) + " names vertex " + std::to_string(index) + " of " +
                 std::to_string(count));
    const Vertex &a = vertices[corner[0]], &b = vertices[corner[1]], &c = vertices[corner[2]];
    const Vec3 e1 = b.p - a.p, e2 = c.p - a.p, cross = Cross(e1, e2);
    const float length_squared = LengthSquared(cross);
    if (!(length_squared > 1e-37f)) {
      ++group->dropped_triangles;
      continue;
    }
    if (!surface.invisible)
      triangles.push_back(
          {{base + corner[0], base + corner[1], base + corner[2]}, static_cast<uint32_t>(group->meshes.size())});
    for (const Vertex* v : {&a, &b, &c}) group->bounds.Extend(v->p);
    if (surface.emission) {
      LightTriangle t{a.p, e1, e2, cross * (1 / std::sqrt(length_squared)), 0.5f * std::sqrt(length_squared)};
      // The side of the vertex normals, as interactions have it for emitters.
      if (record.flags & MeshRecord::kHasNormals) t.n = FaceForward(t.n, a.n + b.n + c.n);
      if (record.flags & MeshRecord::kFlip) t.n = -t.n;
      emitters.push_back(t);
      emitter_uvs.push_back(mesh.uvs.empty() ? LightTable::TriangleUvs{{0, 0}, {1, 0}, {1, 1}}
                                             : LightTable::TriangleUvs{{a.u, a.v}, {b.u, b.v}, {c.u, c.v}});
    }
  }

  // 3. Lights, one a triangle; a given power is that of the whole shape.
  if (surface.emission && !emitters.empty()) {
    LightTable::Emission emission = *surface.emission;
    if (surface.shape.light->power > 0) {
      double area = 0;
      for (const auto& t : emitters) area += t.area;
      emission.radiance = RadianceOfPower(emission, surface.shape.light->power, area);
    }
    for (size_t i = 0; i < emitters.size(); ++i) {
      const int32_t light = parts_.lights.AddTriangle(emitters[i], emission, emitter_uvs[i]);
      if (i == 0) record.first_light = light;
    }
  }
  if (surface.invisible || triangles.size() == record.first_triangle) return;  // no triangle refers to the vertices
  group->vertices.insert(group->vertices.end(), vertices.begin(), vertices.end());
  group->meshes.push_back(record);
}

void ShapeCompiler::AddQuadric(Quadric q, bool sphere, const Surface& surface, GeometryGroup* group) {
  const SourceLocation& where = surface.shape.where;
  const auto& m = q.group_from_object.m;
  // Box, and a bound of the stretch: the longest column, which is the scale itself for similarities.
  const double h = sphere ? 0 : q.height;
  const auto center = q.group_from_object.Point(0, 0, h);
  Bounds3 box;
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis)
    longest = std::max(longest, std::sqrt(m[axis] * m[axis] + m[4 + axis] * m[4 + axis] + m[8 + axis] * m[8 + axis]));
  for (int axis = 0; axis < 3; ++axis) {
    const double half = q.HalfExtent(axis, sphere);
    box.min[axis] = static_cast<float>(center[axis] - half);
    box.max[axis] = static_cast<float>(center[axis] + half);
  }
  if (!WithinReach(box.min) || !WithinReach(box.max))
    Fail(ErrorKind::kInvalidInput, where, std::string("the shape") + kOutOfReach);
  group->bounds.Extend(box);
  q.scale = static_cast<float>(longest * q.radius);
  q.record.flags = surface.flags;
  q.record.material = static_cast<uint32_t>(surface.shape.material);
  q.record.alpha = surface.alpha;
  if (surface.emission) {
    LightTable::Emission emission = *surface.emission;
    // Others are left out by the parser.
    LODESTAR_CHECK(surface.alpha.texture < 0 && (surface.invisible || surface.alpha.value >= 1));
    if (surface.shape.light->power > 0) {
      // Of a similarity; others deviate as their area does.
      const double area =
          sphere ? 4 * double(kPi) * Sqr(q.scale)
                 : double(kPi) * (q.radius * q.radius - q.inner_radius * q.inner_radius) * Sqr(float(longest));
      emission.radiance = RadianceOfPower(emission, surface.shape.light->power, area);
    }
    q.record.first_light = sphere ? parts_.lights.AddSphere(q, emission) : parts_.lights.AddDisk(q, emission);
  }
  if (!surface.invisible) (sphere ? group->spheres : group->disks).push_back(q);
}

// A parallelogram is two triangles exactly. A twisted patch becomes a grid whose distance from the surface is below
// 1e-4 of the patch's extent, with the surface's own normals.
TriangleMesh ShapeCompiler::Tessellate(const BilinearMesh& mesh, const Surface& surface) const {
  const SourceLocation& where = surface.shape.where;
  const size_t count = mesh.positions.size();
  if ((!mesh.normals.empty() && mesh.normals.size() != count) || (!mesh.uvs.empty() && mesh.uvs.size() != count))
    Fail(ErrorKind::kInvalidInput, where, "the mesh has another number of normals or uvs than of vertices");
  bool twisted = false;
  for (const auto& patch : mesh.patches)
    for (const uint32_t index : patch)
      if (index >= count)
        Fail(ErrorKind::kInvalidInput, where,
             "a patch names vertex " + std::to_string(index) + " of " + std::to_string(count));
  const auto twist = [&](const std::array<uint32_t, 4>& k) {
    const auto& p = mesh.positions;
    const float extent = std::max({Length(p[k[1]] - p[k[0]]), Length(p[k[2]] - p[k[0]]), Length(p[k[3]] - p[k[0]])});
    return extent > 0 ? Length(p[k[0]] - p[k[1]] - p[k[2]] + p[k[3]]) / extent : 0;
  };
  for (const auto& patch : mesh.patches) twisted |= twist(patch) > 1e-6f;

  TriangleMesh out;
  for (const auto& k : mesh.patches) {
    const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(twist(k) / 8e-4f))), 1, 64);
    const auto base = static_cast<uint32_t>(out.positions.size());
    const Vec3 p00 = mesh.positions[k[0]], p10 = mesh.positions[k[1]], p01 = mesh.positions[k[2]],
               p11 = mesh.positions[k[3]];
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const float u = float(i) / float(n), v = float(j) / float(n);
        const auto blend = [&](auto a, auto b, auto c, auto d) {
          return (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v;
        };
        out.positions.push_back(blend(p00, p10, p01, p11));
        out.uvs.push_back(mesh.uvs.empty() ? Vec2{u, v}
                                           : blend(mesh.uvs[k[0]], mesh.uvs[k[1]], mesh.uvs[k[2]], mesh.uvs[k[3]]));
        if (!mesh.normals.empty()) {
          out.normals.push_back(blend(mesh.normals[k[0]], mesh.normals[k[1]], mesh.normals[k[2]], mesh.normals[k[3]]));
        } else if (twisted) {
          const Vec3 dpdu = (p10 - p00) * (1 - v) + (p11 - p01) * v, dpdv = (p01 - p00) * (1 - u) + (p11 - p10) * u;
          // In object space, where no transform has mirrored the cross product.
          out.normals.push_back(Normalize(Cross(dpdu, dpdv)));
        }
      }
    const auto at = [&](int i, int j) { return base + static_cast<uint32_t>(j * (n + 1) + i); };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        out.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        out.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
  return out;
}

}  // namespace lodestar
