// Factories, dispatch, and the kinds without microfacets. Rough conductors and dielectrics: bsdf_microfacet.cpp; coats:
// bsdf_coated.cpp.
#include "core/scene/bsdf.h"

#include "core/base/check.h"
#include "core/scene/fresnel.h"
#include "core/scene/microfacet.h"

namespace lodestar {
namespace {

Vec3 Mirrored(Vec3 w) {
  return {-w.x, -w.y, -w.z};
}

// All orders of reflection between the two faces of a pane (Stokes): R + T^2 R / (1 - R^2), with T = 1 - R.
float PaneReflectance(float cos, float eta) {
  const float r = FresnelDielectric(cos, eta).reflectance;
  return r < 1 ? r + Sqr(1 - r) * r / (1 - r * r) : 1;
}

}  // namespace

Bsdf Bsdf::Diffuse(Rgb reflectance) {
  Bsdf b;
  b.kind_ = Kind::kDiffuse;
  b.a_ = reflectance;
  return b;
}

Bsdf Bsdf::Conductor(Rgb eta, Rgb k, Vec2 alpha) {
  Bsdf b;
  b.kind_ = Ggx::IsSmooth(alpha, kSmoothAlpha) ? Kind::kSmoothConductor : Kind::kConductor;
  b.a_ = eta;
  b.b_ = k;
  b.alpha_ = Ggx::Clamped(alpha).alpha;
  return b;
}

Bsdf Bsdf::Dielectric(float eta, Vec2 alpha) {
  LODESTAR_DCHECK(eta > 0);
  Bsdf b;
  b.kind_ = eta == 1 || Ggx::IsSmooth(alpha, kSmoothAlpha) ? Kind::kSmoothDielectric : Kind::kDielectric;
  b.eta_ = eta;
  b.inverse_eta_ = 1 / eta;
  b.alpha_ = Ggx::Clamped(alpha).alpha;
  return b;
}

Bsdf Bsdf::ThinDielectric(float eta) {
  LODESTAR_DCHECK(eta > 0);
  Bsdf b;
  b.kind_ = Kind::kThinDielectric;
  b.eta_ = eta;
  return b;
}

Bsdf Bsdf::DiffuseTransmission(Rgb reflectance, Rgb transmittance) {
  Bsdf b;
  b.kind_ = Kind::kDiffuseTransmission;
  b.a_ = reflectance;
  b.b_ = transmittance;
  const float r = MaxComponent(reflectance), t = MaxComponent(transmittance);
  b.base_energy_ = r + t > 0 ? r / (r + t) : 1;  // probability of reflection
  return b;
}

Bsdf Bsdf::None() {
  return {};
}

BsdfValue Bsdf::EvaluateOther(Vec3 wo, Vec3 wi) const {
  if (wo.z == 0 || wi.z == 0) return {};
  const bool inside = wo.z < 0;
  if (inside) wo = Mirrored(wo), wi = Mirrored(wi);
  switch (kind_) {
    case Kind::kDiffuse:
      return EvaluateDiffuse(wo, wi);
    case Kind::kConductor:
      return wi.z > 0 ? EvaluateConductor(wo, wi) : BsdfValue{};
    case Kind::kDielectric:
      return EvaluateDielectric(wo, wi, inside ? inverse_eta_ : eta_);
    case Kind::kCoatedDiffuse:
    case Kind::kSmoothCoatedDiffuse:
      return wi.z > 0 ? EvaluateCoatedDiffuse(wo, wi, CoatAt(wo)) : BsdfValue{};
    case Kind::kCoatedConductor:
      return wi.z > 0 && HasSmoothLobes() ? EvaluateCoatedConductor(wo, wi, CoatAt(wo)) : BsdfValue{};
    case Kind::kDiffuseTransmission:
      return EvaluateDiffuseTransmission(wo, wi);
    case Kind::kSmoothConductor:
    case Kind::kSmoothDielectric:
    case Kind::kThinDielectric:
    case Kind::kNone:
      break;
  }
  return {};
}

std::optional<BsdfSample> Bsdf::SampleOther(Vec3 wo, float u_lobe, Vec2 u) const {
  if (wo.z == 0) return std::nullopt;
  const bool inside = wo.z < 0;
  if (inside) wo = Mirrored(wo);
  const float eta = inside ? inverse_eta_ : eta_;
  std::optional<BsdfSample> sample;
  switch (kind_) {
    case Kind::kDiffuse:
      sample = SampleDiffuse(wo, u);
      break;
    case Kind::kConductor:
      sample = SampleConductor(wo, u);
      break;
    case Kind::kSmoothConductor:
      sample = MirrorSample(wo, FresnelConductor(wo.z, a_, b_), 1);
      break;
    case Kind::kDielectric:
      sample = SampleDielectric(wo, u_lobe, u, eta);
      break;
    case Kind::kSmoothDielectric:
      sample = SampleSmoothDielectric(wo, u_lobe, eta);
      break;
    case Kind::kThinDielectric:
      sample = SampleThinDielectric(wo, u_lobe);
      break;
    case Kind::kCoatedDiffuse:
    case Kind::kSmoothCoatedDiffuse:
      sample = SampleCoatedDiffuse(wo, u_lobe, u);
      break;
    case Kind::kCoatedConductor:
      sample = SampleCoatedConductor(wo, u_lobe, u);
      break;
    case Kind::kDiffuseTransmission:
      sample = SampleDiffuseTransmission(wo, u_lobe, u);
      break;
    case Kind::kNone:
      break;
  }
  if (inside && sample) sample->wi = Mirrored(sample->wi);
  return sample;
}

BsdfSample Bsdf::MirrorSample(Vec3 wo, Rgb weight, float probability) {
  return {.wi = {-wo.x, -wo.y, wo.z}, .weight = weight, .pdf = probability, .delta = true, .alpha = 0};
}

std::optional<BsdfSample> Bsdf::SampleSmoothDielectric(Vec3 wo, float u_lobe, float eta) const {
  const DielectricFresnel fresnel = FresnelDielectric(wo.z, eta);
  if (u_lobe < fresnel.reflectance) {
    return MirrorSample(wo, Rgb(1), fresnel.reflectance);
  }
  const float inv = 1 / eta;
  return BsdfSample{.wi = {-wo.x * inv, -wo.y * inv, -fresnel.cos_t},
                    .weight = Rgb(inv * inv),
                    .pdf = 1 - fresnel.reflectance,
                    .eta = eta,
                    .delta = true,
                    .transmission = true,
                    .alpha = 0};
}

std::optional<BsdfSample> Bsdf::SampleThinDielectric(Vec3 wo, float u_lobe) const {
  const float r = PaneReflectance(wo.z, eta_);
  if (u_lobe < r) return MirrorSample(wo, Rgb(1), r);
  return BsdfSample{.wi = -wo, .weight = Rgb(1), .pdf = 1 - r, .delta = true, .transmission = true, .alpha = 0};
}

BsdfValue Bsdf::EvaluateDiffuseTransmission(Vec3 wo, Vec3 wi) const {
  const float lambert = std::fabs(wi.z) * kInvPi;
  return wi.z > 0 ? BsdfValue{a_ * lambert, base_energy_ * lambert}
                  : BsdfValue{b_ * lambert, (1 - base_energy_) * lambert};
}

std::optional<BsdfSample> Bsdf::SampleDiffuseTransmission(Vec3 wo, float u_lobe, Vec2 u) const {
  Vec3 wi = SquareToCosineHemisphere(u);
  if (wi.z <= 0) return std::nullopt;
  const bool reflect = u_lobe < base_energy_;
  const float probability = reflect ? base_energy_ : 1 - base_energy_;
  const float pdf = probability * wi.z * kInvPi;
  if (!reflect) wi.z = -wi.z;
  return BsdfSample{.wi = wi, .weight = (reflect ? a_ : b_) / probability, .pdf = pdf, .transmission = !reflect};
}

bool Bsdf::HasSmoothLobes() const {
  switch (kind_) {
    case Kind::kSmoothConductor:
    case Kind::kSmoothDielectric:
    case Kind::kThinDielectric:
    case Kind::kNone:
      return false;
    case Kind::kCoatedConductor:
      return !(coat_flat_ && base_flat_);
    default:
      return true;
  }
}

float Bsdf::DeltaProbability(Vec3 wo) const {
  switch (kind_) {
    case Kind::kSmoothConductor:
    case Kind::kSmoothDielectric:
    case Kind::kThinDielectric:
      return 1;
    case Kind::kSmoothCoatedDiffuse:
    case Kind::kCoatedConductor:
      if (coat_flat_ && base_flat_) return 1;
      return coat_flat_ && wo.z != 0 ? CoatAt({wo.x, wo.y, std::fabs(wo.z)}).lobe_probability : 0;
    default:
      return 0;
  }
}

}  // namespace lodestar
