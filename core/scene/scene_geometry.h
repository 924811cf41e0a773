// The compiled geometry: flat arrays the intersector reads in place and interactions are interpolated from.
//
// All triangle meshes of a group lie in one vertex and two triangle arrays: Embree then builds one tree over many small
// meshes, and a triangle's record (its mesh beside its corners) is one 16-byte load, a vertex one half cache line.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/huge_pages.h"
#include "core/math/bounds.h"
#include "core/scene/description.h"
#include "core/scene/scene_materials.h"
#include "core/scene/scene_types.h"
#include "core/scene/textures.h"

namespace lodestar {

// Embree geometry ids in every group; instances follow from kFirstInstance on (top group only).
enum GeometrySlot : uint32_t { kOpaqueTriangles, kFilteredTriangles, kSpheres, kDisks, kFirstInstance };

struct alignas(32) Vertex {
  Vec3 p;
  float u = 0;
  Vec3 n;
  float v = 0;
};

struct Triangle {
  uint32_t corner[3];
  uint32_t mesh;
};

struct MeshRecord {
  enum Flags : uint32_t {
    kHasNormals = 1,
    kHasUvs = 2,
    kFlip = 4,  // turn cross(e1, e2), for want of normals that say where the outside is
    kNeedsUv = 8,
    kNeedsTangent = 16,
    kEmissive = 32,  // the outside is one side for the whole triangle, as light sampling sees it
    kHasAlpha = 64,  // stochastic opacity, of the shape or of its material
  };
  uint32_t flags = 0;
  uint32_t material = 0;
  int32_t first_light = -1;     // light of the mesh's first triangle
  uint32_t first_triangle = 0;  // in its slot's array
  FloatValue alpha{1};
};

// An affine map in double precision, rows of 4: far-away and tiny quadrics lose nothing to their transform.
struct Affine {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::array<double, 3> Point(double x, double y, double z) const {
    return {m[0] * x + m[1] * y + m[2] * z + m[3], m[4] * x + m[5] * y + m[6] * z + m[7],
            m[8] * x + m[9] * y + m[10] * z + m[11]};
  }
  std::array<double, 3> Vector(double x, double y, double z) const {
    return {m[0] * x + m[1] * y + m[2] * z, m[4] * x + m[5] * y + m[6] * z, m[8] * x + m[9] * y + m[10] * z};
  }
  // The transpose's product: normals, when m is the inverse.
  std::array<double, 3> Transposed(double x, double y, double z) const {
    return {m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z, m[2] * x + m[6] * y + m[10] * z};
  }
  static Affine From(const Transform::Matrix& matrix);
};

inline Vec3 ToVec3(const std::array<double, 3>& v) {
  return {float(v[0]), float(v[1]), float(v[2])};
}

struct Quadric {
  Affine group_from_object, object_from_group;
  double radius = 1, inner_radius = 0, height = 0;
  float scale = 1;  // largest stretch of group_from_object times the radius
  bool reverse = false;
  MeshRecord record;  // material, flags, alpha; first_light is its light

  // Half of what the ellipsoid (of a sphere) or the ellipse (of a disk) spans along an axis of the group.
  double HalfExtent(int axis, bool sphere) const {
    const double* row = group_from_object.m.data() + axis * 4;
    return radius * std::sqrt(row[0] * row[0] + row[1] * row[1] + (sphere ? row[2] * row[2] : 0));
  }
};

// Shapes that share a coordinate system: the world's, or an object definition's.
struct GeometryGroup {
  LargeVector<Vertex> vertices;
  std::array<LargeVector<Triangle>, 2> triangles;  // by slot
  std::vector<MeshRecord> meshes;
  std::vector<Quadric> spheres, disks;
  Bounds3 bounds;
  size_t dropped_triangles = 0;  // degenerate: no area in floats

  bool empty() const { return triangles[0].empty() && triangles[1].empty() && spheres.empty() && disks.empty(); }
  size_t memory_bytes() const;
};

struct Instance {
  uint32_t group = 0;
  Affine world_from_group, group_from_world;
  std::array<float, 12> embree_transform{};  // 3x4, column by column
  float stretch = 1;                         // largest length of an image of a unit vector
  float ray_error =
      0;  // world-space magnitude of what transforming a ray into the group rounds, without the point's own
};

// Surface uv of a hit inside a group, also where no material asked for it.
Vec2 HitUv(const GeometryGroup& group, uint32_t slot, uint32_t primitive, float u, float v, Vec3 ng);
// Whether a ray (in the group's space) meets the surface or passes through its alpha, or through what its material has
// of interfaces: a pure function of the ray and of what it meets, so that each layer on its way decides on its own. A
// sphere is met twice and tells its walls apart by `ng`, its normal there.
bool AlphaAccepts(const GeometryGroup& group, const TextureTable& textures, const MaterialTable& materials,
                  const MeshRecord& record, Vec3 origin, Vec3 direction, uint32_t instance, uint32_t slot,
                  uint32_t primitive, float u, float v, Vec3 ng);

// How far geometry may reach along each axis: the square of a triangle's normal before it is made a unit vector, 3 (2
// kLargestCoordinate)^4 at most, must be a float, and so must the cube of a distance.
inline constexpr float kLargestCoordinate = 1e9f;
inline constexpr const char* kOutOfReach = " lies beyond 1e9 or is not finite; scale the whole scene down";
inline bool WithinReach(Vec3 p) {
  return IsFinite(p) && MaxComponent(Abs(p)) <= kLargestCoordinate;
}

// Error bounds. kRound is half an ulp of 1; the factors are justified and tested in
// tests/scene/accelerator_offset_test.cpp.
inline constexpr float kRound = 0x1p-24f;
inline constexpr float kPointFactor = 6 * kRound;    // of the largest coordinate
inline constexpr float kExtentFactor = 10 * kRound;  // of the primitive's extent

}  // namespace lodestar
