#include "core/scene/scene_geometry.h"

#include <bit>

#include "core/base/hash.h"
#include "core/math/elementary.h"

namespace lodestar {

Affine Affine::From(const Transform::Matrix& matrix) {
  Affine a;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) a.m[row * 4 + column] = matrix[row][column];
  return a;
}

size_t GeometryGroup::memory_bytes() const {
  return vertices.capacity() * sizeof(Vertex) + (triangles[0].capacity() + triangles[1].capacity()) * sizeof(Triangle) +
         meshes.capacity() * sizeof(MeshRecord) + (spheres.capacity() + disks.capacity()) * sizeof(Quadric);
}

Vec2 HitUv(const GeometryGroup& group, uint32_t slot, uint32_t primitive, float u, float v, Vec3 ng) {
  if (slot <= kFilteredTriangles) {
    const Triangle& triangle = group.triangles[slot][primitive];
    if (!(group.meshes[triangle.mesh].flags & MeshRecord::kHasUvs)) return {u + v, v};  // corners (0,0), (1,0), (1,1)
    const Vertex &a = group.vertices[triangle.corner[0]], &b = group.vertices[triangle.corner[1]],
                 &c = group.vertices[triangle.corner[2]];
    const float w = 1 - u - v;
    return {w * a.u + u * b.u + v * c.u, w * a.v + u * b.v + v * c.v};
  }
  const auto turn = [](float y, float x) {
    const float phi = Atan2(y, x) * (0.5f * kInvPi);
    return phi < 0 ? phi + 1 : phi;
  };
  // Sphere: v runs from the south pole up. Disk: v is 0 at the rim and 1 at the inner radius.
  if (slot == kSpheres) return {turn(ng.y, ng.x), 1 - Acos(ng.z) * kInvPi};
  const Quadric& disk = group.disks[primitive];
  const float r = std::sqrt(u * u + v * v) * float(disk.radius);
  return {turn(v, u), (float(disk.radius) - r) / float(disk.radius - disk.inner_radius)};
}

bool AlphaAccepts(const GeometryGroup& group, const TextureTable& textures, const MaterialTable& materials,
                  const MeshRecord& record, Vec3 origin, Vec3 direction, uint32_t instance, uint32_t slot,
                  uint32_t primitive, float u, float v, Vec3 ng) {
  const bool varies = record.alpha.texture >= 0 || (record.flags & MeshRecord::kNeedsUv);
  const Vec2 uv = varies ? HitUv(group, slot, primitive, u, v, ng) : Vec2{};
  const float alpha = textures.Evaluate(record.alpha, uv) * materials.Opacity(record.material, uv);
  if (alpha >= 1) return true;
  if (!(alpha > 0)) return false;
  const auto pair = [](float a, float b) {
    return uint64_t{std::bit_cast<uint32_t>(a)} << 32 | std::bit_cast<uint32_t>(b);
  };
  uint64_t key = MixCombine(pair(origin.x, origin.y), pair(origin.z, direction.x));
  key = MixCombine(key, pair(direction.y, direction.z));
  key = MixCombine(key, uint64_t{instance} << 32 | primitive);
  key = MixCombine(key, uint64_t{slot} << 32 | std::bit_cast<uint32_t>(ng.x));
  key = MixCombine(key, pair(ng.y, ng.z));
  return static_cast<float>(key >> 40) * 0x1p-24f < alpha;
}

}  // namespace lodestar
