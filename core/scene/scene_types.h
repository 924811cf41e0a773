// What travels between the compiled scene and a path kernel: rays, hits, interactions, light samples.
//
// World units are the file's. Directions are unit vectors in world space unless stated.
#pragma once

#include <cstdint>
#include <span>

#include "core/math/frame.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"

namespace lodestar {

struct Ray {
  Vec3 origin;
  Vec3 direction;
  float t_max = kInfinity;  // in units of |direction|
};

// What the intersector found, before anything is interpolated.
struct Hit {
  static constexpr uint32_t kNoInstance = ~0u;
  float t;
  float u, v;         // barycentrics of the second and third corner; on a disk the unit-disk coordinates
  Vec3 ng;            // spheres only: the unit object-space normal
  uint32_t geometry;  // GeometrySlot (scene_geometry.h)
  uint32_t primitive;
  uint32_t instance;  // kNoInstance: none
};

// Probabilities of a scene's light groups (light_groups.h) in units of 2^-16, all positive and of sum 1, in place of
// those by power; empty: by power.
using LightGroupWeights = std::span<const uint16_t>;

struct SurfaceInteraction {
  Vec3 p;   // on the surface, reconstructed from the primitive, not from t
  Vec3 ng;  // unit geometric normal, on the side of the shading normal's hemisphere (emission side after
            // ReverseOrientation)
  Frame shading;
  Vec2 uv;  // valid where the material or its alpha looks at it
  float t;
  float offset;  // a bound of the error of p along ng, and of the intersector's: rays start this far off the surface
                 // along +-ng
  uint32_t material;
  int32_t light = -1;  // emitter index for LightPdf / Emitted; -1: does not emit
};

// The estimator of the light's contribution is f_cos * radiance / pdf for every light, delta or not.
struct LightSample {
  Vec3 wi;        // from the reference point to the light
  Rgb radiance;   // arriving along wi if unoccluded (point and spot: intensity / distance^2; distant: irradiance)
  float pdf = 0;  // > 0, includes the probability of having picked the light; for delta lights that probability alone
  bool delta = false;  // cannot be hit by BSDF sampling: no MIS
  Vec3 target;         // point on the light, pulled off it by its error bound; not set where `infinite`
  bool infinite = false;
  uint8_t group = 0;  // of the light
};

// The environment seen in one direction; black and zero where there is none.
struct EnvironmentSample {
  Rgb radiance;
  float pdf = 0;  // of SampleLight producing this direction through an infinite light
};

}  // namespace lodestar
