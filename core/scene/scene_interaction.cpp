// From a hit to a surface: the point by the primitive's own parameters, and nothing interpolated that the material does
// not look at.
#include <cmath>

#include "core/scene/scene_parts.h"

namespace lodestar {
namespace {

// Moves an interaction from its group's space to the world.
void ToWorld(const Instance& instance, Vec3 tangent, bool needs_tangent, SurfaceInteraction* si) {
  const Vec3 p = si->p;
  si->p = ToVec3(instance.world_from_group.Point(p.x, p.y, p.z));
  const auto normal = [&instance](Vec3 n) {
    return Normalize(ToVec3(instance.group_from_world.Transposed(n.x, n.y, n.z)));
  };
  const Vec3 ns = normal(si->shading.n);
  si->ng = FaceForward(normal(si->ng), ns);  // a stretch may tilt one past the other
  si->shading = needs_tangent ? Frame::FromNormalAndTangent(
                                    ns, ToVec3(instance.world_from_group.Vector(tangent.x, tangent.y, tangent.z)))
                              : Frame::FromNormal(ns);
  // The ray is moved into the group in floats: both spaces' roundings count.
  si->offset = instance.stretch * si->offset +
               kPointFactor * (MaxComponent(Abs(si->p)) + instance.stretch * MaxComponent(Abs(p))) + instance.ray_error;
}

// Direction of growing u; zero where the uvs are degenerate.
Vec3 UvTangent(const Vertex& a, const Vertex& b, const Vertex& c, Vec3 e1, Vec3 e2, bool has_uvs) {
  const float du1 = has_uvs ? b.u - a.u : 1, dv1 = has_uvs ? b.v - a.v : 0;
  const float du2 = has_uvs ? c.u - a.u : 1, dv2 = has_uvs ? c.v - a.v : 1;
  const float determinant = du1 * dv2 - dv1 * du2;
  if (determinant == 0) return {};
  return (e1 * dv2 - e2 * dv1) * (determinant < 0 ? -1.0f : 1.0f);
}

SurfaceInteraction InteractTriangle(const SceneParts& parts, const GeometryGroup& group, const Hit& hit) {
  const Triangle& triangle = group.triangles[hit.geometry][hit.primitive];
  const MeshRecord& mesh = group.meshes[triangle.mesh];
  const Vertex* vertices = group.vertices.data();
  const Vertex &a = vertices[triangle.corner[0]], &b = vertices[triangle.corner[1]], &c = vertices[triangle.corner[2]];
  const Vec3 e1 = b.p - a.p, e2 = c.p - a.p;

  SurfaceInteraction si;
  si.t = hit.t;
  si.material = mesh.material;
  si.light = mesh.flags & MeshRecord::kEmissive
                 ? mesh.first_light + static_cast<int32_t>(hit.primitive - mesh.first_triangle)
                 : -1;
  si.p = a.p + (e1 * hit.u + e2 * hit.v);

  const Vec3 cross = Cross(e1, e2);
  const float inverse_area = 1 / std::sqrt(LengthSquared(cross));
  Vec3 ng = cross * inverse_area;
  // A sliver's normal, here and in the intersector, is less certain by its aspect ratio.
  const float extent = std::max(MaxComponent(Abs(e1)), MaxComponent(Abs(e2)));
  const float aspect = std::min(extent * extent * inverse_area, 1e3f);
  si.offset = kPointFactor * std::max(MaxComponent(Abs(a.p)), MaxComponent(Abs(si.p))) +
              kExtentFactor * extent * std::max(aspect, 1.0f);

  Vec3 ns;
  if (mesh.flags & MeshRecord::kHasNormals) {
    const float w = 1 - hit.u - hit.v;
    ns = a.n * w + b.n * hit.u + c.n * hit.v;
    const float length_squared = LengthSquared(ns);
    if (length_squared > 1e-30f) {
      ns = ns * (1 / std::sqrt(length_squared));
      ng = FaceForward(ng, mesh.flags & MeshRecord::kEmissive ? a.n + b.n + c.n : ns);
    } else {
      ns = ng;
    }
  } else {
    if (mesh.flags & MeshRecord::kFlip) ng = -ng;
    ns = ng;
  }
  si.ng = ng;
  const bool needs_tangent = mesh.flags & MeshRecord::kNeedsTangent;
  if (mesh.flags & MeshRecord::kNeedsUv) si.uv = HitUv(group, hit.geometry, hit.primitive, hit.u, hit.v, {});
  const Vec3 tangent = needs_tangent ? UvTangent(a, b, c, e1, e2, mesh.flags & MeshRecord::kHasUvs) : Vec3{};
  if (hit.instance == Hit::kNoInstance) [[likely]] {
    si.shading = needs_tangent ? Frame::FromNormalAndTangent(ns, tangent) : Frame::FromNormal(ns);
  } else {
    si.shading.n = ns;
    ToWorld(parts.instances[hit.instance], tangent, needs_tangent, &si);
  }
  return si;
}

SurfaceInteraction InteractQuadric(const SceneParts& parts, const GeometryGroup& group, const Hit& hit) {
  const bool sphere = hit.geometry == kSpheres;
  const Quadric& q = (sphere ? group.spheres : group.disks)[hit.primitive];
  SurfaceInteraction si;
  si.t = hit.t;
  si.material = q.record.material;
  si.light = q.record.first_light;
  // On the surface by its own parameters, whatever t was rounded to.
  const double r = q.radius;
  const double x = sphere ? hit.ng.x * r : hit.u * r, y = sphere ? hit.ng.y * r : hit.v * r,
               z = sphere ? hit.ng.z * r : q.height;
  si.p = ToVec3(q.group_from_object.Point(x, y, z));
  const Vec3 object_normal = sphere ? hit.ng : Vec3{0, 0, 1};
  si.ng = Normalize(ToVec3(q.object_from_group.Transposed(object_normal.x, object_normal.y, object_normal.z)));
  if (q.reverse) si.ng = -si.ng;
  si.offset = kPointFactor * MaxComponent(Abs(si.p)) + kExtentFactor * q.scale;
  const bool needs_tangent = q.record.flags & MeshRecord::kNeedsTangent;
  if (q.record.flags & MeshRecord::kNeedsUv) si.uv = HitUv(group, hit.geometry, hit.primitive, hit.u, hit.v, hit.ng);
  const Vec3 tangent = needs_tangent ? ToVec3(q.group_from_object.Vector(-y, x, 0)) : Vec3{};
  if (hit.instance == Hit::kNoInstance) {
    si.shading = needs_tangent ? Frame::FromNormalAndTangent(si.ng, tangent) : Frame::FromNormal(si.ng);
  } else {
    si.shading.n = si.ng;
    ToWorld(parts.instances[hit.instance], tangent, needs_tangent, &si);
  }
  return si;
}

}  // namespace

SurfaceInteraction Interact(const SceneParts& parts, const Hit& hit) {
  const GeometryGroup& group = parts.groups[hit.instance == Hit::kNoInstance ? 0 : parts.instances[hit.instance].group];
  return hit.geometry <= kFilteredTriangles ? InteractTriangle(parts, group, hit) : InteractQuadric(parts, group, hit);
}

}  // namespace lodestar
