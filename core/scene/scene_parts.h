// The parts of a compiled scene, and the steps that make them. For the scene's own files.
#pragma once

#include <memory>
#include <vector>

#include "core/scene/accelerator.h"
#include "core/scene/lights.h"
#include "core/scene/scene.h"
#include "core/scene/scene_geometry.h"
#include "core/scene/scene_materials.h"
#include "core/scene/textures.h"

namespace lodestar {

// Nothing here moves once the accelerator is built: it reads the groups in place.
struct SceneParts {
  TextureTable textures;
  MaterialTable materials;
  std::vector<GeometryGroup> groups;  // [0]: the world
  std::vector<Instance> instances;
  LightTable lights;
  std::unique_ptr<Accelerator> accelerator;
};

// Adds shapes to groups, and area lights to the table.
class ShapeCompiler {
 public:
  ShapeCompiler(const SceneDescription& description, SceneParts* parts) : description_(description), parts_(*parts) {}
  // group_from_object: the shape's transform, after an instance's where that is flattened. `in_object`: area lights are
  // refused.
  void Add(const ShapeDescription& shape, const Transform& group_from_object, GeometryGroup* group, bool in_object);

 private:
  struct Surface;
  void AddMesh(const TriangleMesh& mesh, const Surface& surface, GeometryGroup* group);
  void AddQuadric(Quadric quadric, bool sphere, const Surface& surface, GeometryGroup* group);
  TriangleMesh Tessellate(const BilinearMesh& mesh, const Surface& surface) const;

  const SceneDescription& description_;
  SceneParts& parts_;
};

// The surface at a hit.
SurfaceInteraction Interact(const SceneParts& parts, const Hit& hit);

// Groups, instances, lights, accelerator; `parts` holds textures and materials already.
void CompileGeometry(const SceneDescription& description, SceneParts* parts);
void CompileLights(const SceneDescription& description, SceneParts* parts);
SceneNeeds FindNeeds(const SceneDescription& description, const SceneParts& parts);
ContentHash HashScene(const SceneDescription& description, const SceneParts& parts);

}  // namespace lodestar
