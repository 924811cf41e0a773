// Ray queries over the compiled geometry. The only file that knows Embree.
//
// Bit-identity: the device is pinned to one instruction set, trees are built by one thread (a parallel build may order
// primitives by scheduling), and filters are pure functions of ray and primitive.
#pragma once

#include <memory>
#include <vector>

#include "core/scene/scene_geometry.h"
#include "core/scene/scene_types.h"

namespace lodestar {

class Accelerator {
 public:
  // groups[0] is the world. Groups, instances, textures and materials must outlive the accelerator and stay where they
  // are.
  Accelerator(const std::vector<GeometryGroup>& groups, const std::vector<Instance>& instances,
              const TextureTable& textures, const MaterialTable& materials);
  ~Accelerator();
  Accelerator(const Accelerator&) = delete;
  Accelerator& operator=(const Accelerator&) = delete;

  bool Intersect(const Ray& ray, Hit* hit) const;
  bool Unoccluded(const Ray& ray) const;
  size_t memory_bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  void* scene_ = nullptr;  // the world's RTCScene
};

}  // namespace lodestar
