// A BSDF at one hit: the material's parameters with their textures looked up, a closed set of kinds, no allocation.
//
// Conventions: directions point away from the surface, are unit, and local to the shading frame (normal +z). Evaluate returns f * |cos wi|
// (1/sr), densities are per solid angle of wi. Radiance travels from wi to wo: refraction scales by 1/eta^2. Both sides of opaque materials reflect.
#pragma once

#include <cstdint>
#include <optional>

#include "core/math/rgb.h"
#include "core/math/vec.h"

namespace lodestar {

struct BsdfValue {
  Rgb f_cos;      // f(wo, wi) |cos wi|, smooth lobes only: delta lobes evaluate to zero
  float pdf = 0;  // of Sample() producing wi by a smooth lobe
};

struct BsdfSample {
  Vec3 wi;
  Rgb weight;                // f |cos| / pdf for a smooth sample (all smooth lobes together); for a delta one its share over its probability
  float pdf = 0;             // smooth: as Evaluate(wo, wi).pdf; delta: the discrete probability of the lobe
  float eta = 1;             // relative index along the path: > 1 on entering a denser medium; for roulette
  bool delta = false;
  bool transmission = false;
};

class Bsdf {
 public:
  enum class Kind : uint8_t {
    kDiffuse, kConductor, kSmoothConductor, kDielectric, kSmoothDielectric, kThinDielectric,
    kCoatedDiffuse, kSmoothCoatedDiffuse, kCoatedConductor, kDiffuseTransmission, kNone,
  };

  BsdfValue Evaluate(Vec3 wo, Vec3 wi) const;
  // Nothing where the sample failed (grazing, below the surface): the path ends, with weight zero.
  std::optional<BsdfSample> Sample(Vec3 wo, float u_lobe, Vec2 u) const;

  Kind kind() const { return kind_; }
  // False where every lobe is a delta: neither lights nor guides can be sampled for.
  bool HasSmoothLobes() const;
  // Probability that Sample() takes a delta lobe, given wo: what remains is smooth.
  float DeltaProbability(Vec3 wo) const;
  // Hemispherical-directional reflectance (and transmittance), approximate; for AOVs and roulette only.
  Rgb Albedo(Vec3 wo) const;

  // Factories; `alpha` are GGX alphas after remapping. Alphas below kSmoothAlpha become delta lobes.
  static Bsdf Diffuse(Rgb reflectance);
  static Bsdf Conductor(Rgb eta, Rgb k, Vec2 alpha);
  static Bsdf Dielectric(float eta, Vec2 alpha);
  static Bsdf ThinDielectric(float eta);
  static Bsdf CoatedDiffuse(Rgb reflectance, float eta, Vec2 alpha);
  static Bsdf CoatedConductor(float interface_eta, Vec2 interface_alpha, Rgb eta, Rgb k, Vec2 alpha);
  static Bsdf DiffuseTransmission(Rgb reflectance, Rgb transmittance);
  static Bsdf None();

  static constexpr float kSmoothAlpha = 1e-3f;

 private:
  Kind kind_ = Kind::kNone;
  // The implementer of bsdf.cpp settles the private parameters.
};

}  // namespace lodestar
