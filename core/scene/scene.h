// The compiled scene: what a path kernel asks of it. Immutable after Compile, shared by all threads.
//
// World units are the file's. Directions are unit vectors in world space; pdfs are per solid angle at the reference
// point and include the probability of having picked the light.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/hash.h"
#include "core/math/bounds.h"
#include "core/math/frame.h"
#include "core/math/rgb.h"
#include "core/scene/bsdf.h"
#include "core/scene/camera.h"
#include "core/scene/description.h"
#include "core/scene/scene_types.h"

namespace lodestar {

// What the scene contains: for reports, and for the choice among the variants of the path kernel
// (core/tracing/path_kernel.h).
struct SceneNeeds {
  bool textures = false, alpha = false, environment = false, delta_lobes = false, smooth_lobes = true,
       transmission = false;
  // unseen_lights: those that no path can meet, points, spots, distant ones and shapes of opacity 0.
  bool area_lights = false, unseen_lights = false, mix = false, instances = false, quadrics = false, lens = false;
  bool Lights() const { return area_lights || unseen_lights || environment; }
  // Whether BSDFs are made at the hit.
  bool BsdfsAtHits() const { return textures || mix; }
  // Whether there is anything that guiding could learn.
  bool Guidable() const { return smooth_lobes && Lights(); }
  // What there is, in words with spaces between them; "nothing".
  std::string ToString() const;
  // What there is not, and what renders leave out for that: "environment (left out of the path kernel); ...";
  // "nothing".
  std::string NotNeeded() const;
};

class Scene {
 public:
  // Throws Error with file and line of the offending directive. Builds deterministic acceleration structures
  // (single-threaded tree builds).
  static std::shared_ptr<const Scene> Compile(const SceneDescription& description);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  // ---- rays ----
  bool Intersect(const Ray& ray, Hit* hit) const;
  SurfaceInteraction Interaction(const Hit& hit) const;
  // Nothing between the surface point and the target point / direction.
  bool Unoccluded(const Ray& ray) const;
  // The origin of a ray that leaves the surface in direction w without meeting it again.
  static Vec3 OffsetOrigin(const SurfaceInteraction& si, Vec3 w) {
    return si.p + si.ng * (Dot(w, si.ng) < 0 ? -si.offset : si.offset);
  }

  // ---- surfaces ----
  // wo: local to si.shading; `u_mix` in [0,1) resolves mix materials.
  Bsdf BsdfAt(const SurfaceInteraction& si, float u_mix) const;
  // The same, of a material without textures that is no mix; any material where the scene needs neither.
  const Bsdf& ReadyBsdf(const SurfaceInteraction& si) const;

  // ---- lights ----
  bool has_lights() const;
  // Nothing where the light picked cannot light p (wrong side, zero radiance). To be combined with directions drawn for
  // the surface: the dim part of an environment image is never sampled (density 0, see light_environment.h).
  // u_pick in [0, 1) should have more than 24 bits where there are many lights (Sampler::Refine).
  // With `weights`, a group is chosen by them and a light of it by power; the sample's pdf includes that.
  std::optional<LightSample> SampleLight(Vec3 p, double u_pick, Vec2 u, LightGroupWeights weights = {}) const;
  // The same among the lights that no path can meet, by power; nothing where there are none.
  std::optional<LightSample> SampleUnseenLight(Vec3 p, double u_pick, Vec2 u) const;
  // Radiance leaving the emitter of si towards wo_world (world space).
  Rgb Emitted(const SurfaceInteraction& si, Vec3 wo_world) const;
  // Density with which SampleLight(from, ..) produces the direction to si, by power.
  float LightPdf(Vec3 from, const SurfaceInteraction& si) const;
  // Of a ray that left the scene; both at once cost little more than one.
  EnvironmentSample Environment(Vec3 wi) const;
  // Probability of picking each group by power; empty without light.
  const std::vector<float>& light_groups() const;
  // The factors of LightPdf, and of Environment's density, where groups are chosen by `weights` (not empty).
  float LightRatio(LightGroupWeights weights, int32_t light) const;
  float EnvironmentRatio(LightGroupWeights weights) const;

  const Camera& camera() const { return *camera_; }
  const Bounds3& bounds() const { return bounds_; }  // of all finite geometry
  const SceneNeeds& needs() const { return needs_; }
  int resolution_x() const { return resolution_x_; }
  int resolution_y() const { return resolution_y_; }
  const PixelFilterDescription& filter() const { return filter_; }
  int max_depth() const { return max_depth_; }
  // Of everything that determines the picture: geometry, materials, textures' bytes, camera, resolution. Two workers
  // with the same hash have compiled the same scene.
  const ContentHash& hash() const { return hash_; }
  size_t triangle_count() const { return triangle_count_; }        // of each object definition once
  size_t dropped_triangles() const { return dropped_triangles_; }  // without area
  size_t memory_bytes() const { return memory_bytes_; }

 private:
  Scene();
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::unique_ptr<Camera> camera_;
  Bounds3 bounds_;
  SceneNeeds needs_;
  int resolution_x_ = 0, resolution_y_ = 0, max_depth_ = 5;
  PixelFilterDescription filter_;
  ContentHash hash_;
  size_t triangle_count_ = 0, dropped_triangles_ = 0, memory_bytes_ = 0;
};

}  // namespace lodestar
