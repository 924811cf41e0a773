// A BSDF at one hit: the material's parameters with their textures looked up, a closed set of kinds, no allocation.
//
// Conventions: directions point away from the surface, are unit, and local to the shading frame (normal +z). Evaluate
// returns f * |cos wi| (1/sr), densities are per solid angle of wi. Radiance travels from wi to wo: refraction scales
// by 1/eta^2. Both sides of opaque materials reflect.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/math/warp.h"
#include "core/scene/layering.h"

namespace lodestar {

struct BsdfValue {
  Rgb f_cos;      // f(wo, wi) |cos wi|, smooth lobes only: delta lobes evaluate to zero
  float pdf = 0;  // of Sample() producing wi by a smooth lobe
};

struct BsdfSample {
  Vec3 wi;
  Rgb weight;     // f |cos| / pdf for a smooth sample (all smooth lobes together); for a delta one its share over its
                  // probability
  float pdf = 0;  // smooth: as Evaluate(wo, wi).pdf; delta: the discrete probability of the lobe
  float eta = 1;  // relative index along the path: > 1 on entering a denser medium; for roulette
  bool delta = false;
  bool transmission = false;
  float alpha = 1;  // GGX alpha of the lobe drawn from, the mean of an anisotropic one's; 0: delta, 1: diffuse
};

// The smooth lobes by name, for methods that weigh directions by them without evaluating the BSDF.
struct BsdfLobe {
  enum class Kind : uint8_t {
    kDiffuseReflection,    // on wo's side
    kGgxReflection,        // on wo's side, about the mirror direction
    kDiffuseTransmission,  // on the other side
  };
  Kind kind;
  Vec2 alpha;        // of a GGX lobe, along the frame's x and y
  float weight = 0;  // luminance of the lobe's albedo at wo over that of all that the BSDF scatters; > 0
};
// Their weights add up to 1 less the shares of delta lobes and of rough refraction, which no kind here describes.
struct BsdfLobes {
  std::array<BsdfLobe, 2> lobes;
  int count = 0;
  const BsdfLobe* begin() const { return lobes.data(); }
  const BsdfLobe* end() const { return lobes.data() + count; }
};

class Bsdf {
 public:
  enum class Kind : uint8_t {
    kDiffuse,
    kConductor,
    kSmoothConductor,
    kDielectric,
    kSmoothDielectric,
    kThinDielectric,
    kCoatedDiffuse,
    kSmoothCoatedDiffuse,
    kCoatedConductor,
    kDiffuseTransmission,
    kNone,
  };

  BsdfValue Evaluate(Vec3 wo, Vec3 wi) const {
    if (kind_ == Kind::kDiffuse) return EvaluateDiffuse(wo, wi);
    return EvaluateOther(wo, wi);
  }
  // Nothing where the sample failed (grazing, on the wrong side): the path ends, with weight zero. Hence Evaluate().pdf
  // integrates to 1 - DeltaProbability(wo) - P(failure); P(failure) > 0 only for rough dielectrics and coated conductors.
  std::optional<BsdfSample> Sample(Vec3 wo, float u_lobe, Vec2 u) const {
    if (kind_ == Kind::kDiffuse) return SampleDiffuse(wo, u);
    return SampleOther(wo, u_lobe, u);
  }

  Kind kind() const { return kind_; }
  // False where every lobe is a delta: neither lights nor guides can be sampled for.
  bool HasSmoothLobes() const;
  // Probability that Sample() takes a delta lobe, given wo: what remains is smooth.
  float DeltaProbability(Vec3 wo) const;
  // Hemispherical-directional reflectance (and transmittance), approximate; for AOVs and roulette only.
  Rgb Albedo(Vec3 wo) const;
  // As approximate as Albedo. The base of a coated conductor counts as the GGX lobe that it looks like from outside.
  BsdfLobes Lobes(Vec3 wo) const;
  // GGX alpha (the mean of an anisotropic one's) of the smooth lobe that gives wi the greatest density; 1: a diffuse
  // one. What BsdfSample::alpha is, for a direction that something else has drawn.
  float AlphaAt(Vec3 wo, Vec3 wi) const;

  // As BsdfSample::eta, of a smooth direction that something else has drawn.
  float EtaAcross(Vec3 wo, Vec3 wi) const {
    return kind_ == Kind::kDielectric && wo.z * wi.z < 0 ? (wo.z > 0 ? eta_ : inverse_eta_) : 1;
  }

  // Factories; `alpha` are GGX alphas after remapping. Alphas (both) below kSmoothAlpha become delta lobes, as does a
  // dielectric of eta 1. All are cheap enough to be called at every hit, where textures vary; the coated ones look
  // their table up by eta, which the first call builds (50 ms): call them once while compiling.
  static Bsdf Diffuse(Rgb reflectance);
  // Exact Fresnel reflection of a complex index, and refraction, by single scattering on GGX, as pbrt-v4: rough ones
  // lose energy, see docs/decisions/0019-multiple-scattering.md.
  static Bsdf Conductor(Rgb eta, Rgb k, Vec2 alpha);
  static Bsdf Dielectric(float eta, Vec2 alpha);
  static Bsdf ThinDielectric(float eta);
  // A base of that reflectance coupled to the reflection lobe of a dielectric coat (after Kelemen and Szirmay-Kalos
  // 2001): it returns the reflectance's share of what the coat lets in head-on, in every direction, but never more than
  // the lobe leaves. Reciprocal, and of albedo 1 in every direction where the reflectance is 1, for smooth and rough
  // coats alike; 0.9 to 1 for anisotropic ones, whose coupling is looked up at an isotropic alpha for each direction.
  // See bsdf_coated.cpp and docs/decisions/0005-coats.md.
  static Bsdf CoatedDiffuse(Rgb reflectance, float eta, Vec2 alpha);
  // A conductor under a dielectric interface, nothing absorbed between: exact for a flat interface up to the first
  // reflection on the base (and in full where both are flat), approximate beyond. eta, k are relative to vacuum and
  // divided by interface_eta here, as pbrt-v4 does. See bsdf_coated.cpp.
  static Bsdf CoatedConductor(float interface_eta, Vec2 interface_alpha, Rgb eta, Rgb k, Vec2 alpha);
  static Bsdf DiffuseTransmission(Rgb reflectance, Rgb transmittance);
  static Bsdf None();

  // kDiffuse, kCoatedDiffuse and kSmoothCoatedDiffuse with another reflectance: what a texture changes from hit to hit.
  Bsdf WithReflectance(Rgb reflectance) const;

  static constexpr float kSmoothAlpha = 1e-3f;

 private:
  BsdfValue EvaluateDiffuse(Vec3 wo, Vec3 wi) const {
    if (!(wo.z * wi.z > 0)) return {};
    const float pdf = std::fabs(wi.z) * kInvPi;
    return {a_ * pdf, pdf};
  }
  std::optional<BsdfSample> SampleDiffuse(Vec3 wo, Vec2 u) const {
    Vec3 wi = SquareToCosineHemisphere(u);
    if (wi.z <= 0 || wo.z == 0) return std::nullopt;
    const float pdf = wi.z * kInvPi;
    if (wo.z < 0) wi.z = -wi.z;
    return BsdfSample{wi, a_, pdf};
  }
  BsdfValue EvaluateOther(Vec3 wo, Vec3 wi) const;
  std::optional<BsdfSample> SampleOther(Vec3 wo, float u_lobe, Vec2 u) const;

  static BsdfSample MirrorSample(Vec3 wo, Rgb weight, float probability);
  // Of a value whose wi was drawn: nothing where the density vanished.
  static std::optional<BsdfSample> SampleOf(Vec3 wi, const BsdfValue& value, float alpha) {
    if (!(value.pdf > 0)) return std::nullopt;
    return BsdfSample{.wi = wi, .weight = value.f_cos / value.pdf, .pdf = value.pdf, .alpha = alpha};
  }

  // wo.z > 0 in all of these (the dispatcher mirrors both directions); `eta`: of the far side over wo's.
  BsdfValue EvaluateConductor(Vec3 wo, Vec3 wi) const;
  std::optional<BsdfSample> SampleConductor(Vec3 wo, Vec2 u) const;
  BsdfValue EvaluateDielectric(Vec3 wo, Vec3 wi, float eta) const;
  std::optional<BsdfSample> SampleDielectric(Vec3 wo, float u_lobe, Vec2 u, float eta) const;
  std::optional<BsdfSample> SampleSmoothDielectric(Vec3 wo, float u_lobe, float eta) const;
  std::optional<BsdfSample> SampleThinDielectric(Vec3 wo, float u_lobe) const;
  BsdfValue EvaluateDiffuseTransmission(Vec3 wo, Vec3 wi) const;
  std::optional<BsdfSample> SampleDiffuseTransmission(Vec3 wo, float u_lobe, Vec2 u) const;

  // What of a coat depends on wo alone.
  struct CoatState {
    float reflectance;       // of the lobe: Fresnel at wo of a flat interface, else 1 - transmittance
    float transmittance;     // to the base
    float lobe_probability;  // of sampling the coat's own lobe
  };
  CoatState CoatAt(Vec3 wo) const;
  BsdfValue EvaluateCoatedDiffuse(Vec3 wo, Vec3 wi, const CoatState& state) const;
  std::optional<BsdfSample> SampleCoatedDiffuse(Vec3 wo, float u_lobe, Vec2 u) const;
  BsdfValue EvaluateCoatedConductor(Vec3 wo, Vec3 wi, const CoatState& state) const;
  std::optional<BsdfSample> SampleCoatedConductor(Vec3 wo, float u_lobe, Vec2 u) const;
  Rgb FlatCoatedConductorReflectance(float cos_o) const;
  Vec2 ApparentBaseAlpha() const;
  static BsdfSample SampleFlatCoat(Vec3 wo, const CoatState& state);
  BsdfValue CoatLobe(Vec3 wo, Vec3 wi) const;
  float CoatTransmittance(Vec3 w) const;
  Rgb MeanCoatedBase() const;
  // What the base of a coated diffuse returns of light at a direction of that transmittance.
  Rgb CoatedBase(float transmittance) const {
    return {std::min(c_.r, transmittance), std::min(c_.g, transmittance), std::min(c_.b, transmittance)};
  }
  void SetCoat(float eta, Vec2 alpha);

  Kind kind_ = Kind::kNone;
  bool coat_flat_ = false, base_flat_ = false;
  uint8_t coat_row_ = 0, base_row_ = 0;
  Rgb a_;                            // reflectance, or eta of a conductor
  Rgb b_;                            // transmittance, k of a conductor, or 1 / (pi G) of a coated base (decision 0005)
  Rgb c_;                            // what a coated diffuse base returns at most
  float eta_ = 1, inverse_eta_ = 1;  // of the inside (below) over the outside
  Vec2 alpha_;                       // of the interface, or of a conductor without a coat
  Vec2 base_alpha_;                  // of a coated conductor, widened by the coat
  float coat_row_t_ = 0, base_row_t_ = 0;
  float base_energy_ = 0;  // of the base per unit of light transmitted to it: exact for a diffuse one, an estimate for
                           // sampling of a conductor
  const CoatTable* table_ = nullptr;
};
static_assert(sizeof(Bsdf) <= 96 && std::is_trivially_copyable_v<Bsdf>);

}  // namespace lodestar
