// For tests of the path kernel: the paths of a small picture.
#pragma once

#include <cstdint>
#include <vector>

#include "core/tracing/path_kernel.h"

namespace lodestar {

struct SmallPicture {
  uint32_t width, height, passes;
  uint64_t seed = 1;
  float pixel = 0;  // what each pixel is expected to have, 0 if that is not known
};

// Calls visit(radiance, vertices) for each path; the vertices are those of this path where the kernel records.
template <class Kernel, class Visit>
PathCounters TracePaths(const Scene& scene, const Kernel& kernel, const SmallPicture& picture, const Visit& visit) {
  PathCounters counters;
  std::vector<PathVertex> path;
  for (uint32_t y = 0; y < picture.height; ++y)
    for (uint32_t x = 0; x < picture.width; ++x)
      for (uint32_t pass = 0; pass < picture.passes; ++pass) {
        Sampler sampler(picture.seed, x, y, pass);
        const Vec2 u = sampler.Next2D();
        const CameraRay ray = scene.camera().Generate({static_cast<float>(x) + u.x, static_cast<float>(y) + u.y}, {});
        const Rgb radiance = kernel.Trace(ray, picture.pixel, sampler, &counters, &path);
        visit(radiance, path);
      }
  return counters;
}

}  // namespace lodestar
