// The scene's lights: a closed set of kinds in one flat table, picked by emitted power.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/math/bounds.h"
#include "core/math/distribution.h"
#include "core/scene/light_environment.h"
#include "core/scene/light_groups.h"
#include "core/scene/light_shapes.h"
#include "core/scene/scene_geometry.h"
#include "core/scene/scene_types.h"

namespace lodestar {

class LightTable {
 public:
  // How an area light emits.
  struct Emission {
    Rgb radiance;
    bool two_sided = false;
    bool hidden = false;  // an opacity of zero: lights the scene and is not seen
    FloatValue alpha{1};  // opacity; textured for triangles only
  };
  struct TriangleUvs {
    Vec2 a, b, c;
  };

  // ---- compile: every Add returns the light's index ----
  int32_t AddTriangle(const LightTriangle& triangle, const Emission& emission, const TriangleUvs& uvs);
  int32_t AddSphere(const Quadric& quadric, const Emission& emission);
  int32_t AddDisk(const Quadric& quadric, const Emission& emission);
  void AddPoint(const PointLight& light);
  void AddSpot(const SpotLight& light);
  void AddDistant(const DistantLight& light);
  void AddEnvironment(EnvironmentLight light);
  // Sets the probabilities of picking. One part in a hundred is shared equally, so that no light that power underrates
  // is starved.
  void Finish(const Bounds3& bounds);

  // ---- use ----
  bool empty() const { return lights_.empty(); }
  std::optional<LightSample> Sample(const TextureTable& textures, Vec3 p, double u_pick, Vec2 u,
                                    LightGroupWeights weights) const;
  // Among the lights that no path can meet, by power.
  std::optional<LightSample> SampleUnseen(const TextureTable& textures, Vec3 p, double u_pick, Vec2 u) const;
  const LightGroups& groups() const { return groups_; }
  Rgb Emitted(int32_t light, Vec3 ng, Vec3 wo) const {
    const Light& l = lights_[light];
    return l.two_sided || Dot(ng, wo) > 0 ? l.radiance : Rgb();
  }
  float Pdf(Vec3 from, const SurfaceInteraction& si) const;
  EnvironmentSample Environment(Vec3 wi) const;
  bool has_environment() const { return !environments_.empty(); }
  bool has_area_lights() const { return has_area_lights_; }
  bool has_unseen_lights() const { return !unseen_.empty(); }
  size_t size() const { return lights_.size(); }
  size_t memory_bytes() const;

 private:
  enum class Kind : uint8_t { kTriangle, kSphere, kEllipsoid, kDisk, kPoint, kSpot, kDistant, kEnvironment };
  struct Light {
    explicit Light(Kind k) : kind(k) {}
    Kind kind;
    bool two_sided = false, hidden = false, reversed = false;
    float pick = 0;
    Rgb radiance;  // or intensity, or irradiance
    LightTriangle
        triangle;  // triangle; disk: p0 centre, e1 and e2 its half axes; sphere: p0 centre; spot, distant: n the axis
    float extent = 0;                    // largest edge or radius; sphere: radius
    float cos_total = 0, cos_start = 0;  // spot; disk: cos_start = inner / outer radius
    int32_t side = -1;                   // index into alphas_, quadrics_ or environments_
    double power = 0;
  };
  struct Alpha {
    FloatValue alpha;
    TriangleUvs uvs;
  };
  std::optional<LightSample> SampleOne(const Light& light, const TextureTable& textures, Vec3 p, Vec2 u) const;
  std::optional<LightSample> SampleArea(const Light& light, const TextureTable& textures, Vec3 p, Vec2 u) const;
  std::optional<LightSample> SampleDelta(const Light& light, Vec3 p) const;
  LightSample SampleEnvironment(const Light& light, Vec2 u) const;
  std::optional<DirectionSample> SampleEllipsoid(const Light& light, Vec3 p, Vec2 u, Vec3* n) const;
  float EllipsoidPdf(const Light& light, Vec3 offset, Vec3 point, Vec3 n) const;
  int32_t AddArea(Light light, const Emission& emission, double area);

  std::vector<Light> lights_;
  std::vector<Alpha> alphas_;
  std::vector<Quadric> quadrics_;
  std::vector<EnvironmentLight> environments_;
  std::vector<float> environment_pick_;
  AliasTable table_;
  std::vector<uint32_t> unseen_;  // lights that no path can meet
  AliasTable unseen_table_;
  LightGroups groups_;
  bool has_area_lights_ = false;
};

}  // namespace lodestar
