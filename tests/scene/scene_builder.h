// Scene descriptions by hand, for the tests of the compiled scene.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/scene/scene.h"

namespace lodestar::test {

inline TriangleMesh Quad(Vec3 corner, Vec3 e1, Vec3 e2) {
  TriangleMesh mesh;
  mesh.positions = {corner, corner + e1, corner + e1 + e2, corner + e2};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// Normals point outwards.
inline TriangleMesh Box(Vec3 low, Vec3 high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

struct SceneBuilder {
  SceneDescription d;
  SceneBuilder() {
    d.materials.push_back({"grey", DiffuseMaterial{}, {}});
    d.resolution_x = d.resolution_y = 16;
  }
  template <class Shape>
  ShapeDescription& Add(Shape shape, const Transform& world_from_object = Transform()) {
    ShapeDescription s;
    s.kind = std::move(shape);
    s.world_from_object = world_from_object;
    s.material = 0;
    s.where = {"test.pbrt", 10 + static_cast<int>(d.shapes.size()), 3};
    d.shapes.push_back(std::move(s));
    return d.shapes.back();
  }
  template <class Shape>
  ShapeDescription& AddLight(Shape shape, Rgb radiance, const Transform& world_from_object = Transform()) {
    ShapeDescription& s = Add(std::move(shape), world_from_object);
    s.light = AreaLightDescription{radiance, false, 0, {"test.pbrt", 9, 1}};
    return s;
  }
  template <class Light>
  void AddLight(Light light) {
    d.lights.push_back({std::move(light), Transform(), {"test.pbrt", 5, 1}});
  }
  std::shared_ptr<const Scene> Compile() const { return Scene::Compile(d); }
};

inline Ray Towards(Vec3 from, Vec3 to) {
  return {from, Normalize(to - from), kInfinity};
}

}  // namespace lodestar::test
