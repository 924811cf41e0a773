// Rough conductors and dielectrics: GGX with visible normals (microfacet.h). The dielectric follows Walter et al. 2007,
// section 5, with the height-correlated masking for both lobes, as pbrt-v4 has it.
#include "core/scene/bsdf.h"
#include "core/scene/fresnel.h"
#include "core/scene/microfacet.h"

namespace lodestar {

// ---- conductor ------------------------------------------------------------------------------------------------------

BsdfValue Bsdf::EvaluateConductor(Vec3 wo, Vec3 wi) const {
  const GgxReflection r = EvaluateReflection(Ggx{alpha_}, wo, wi);
  return {FresnelConductor(r.cos, a_, b_) * r.value, r.pdf};
}

std::optional<BsdfSample> Bsdf::SampleConductor(Vec3 wo, Vec2 u) const {
  const Ggx ggx{alpha_};
  const Vec3 wi = ggx.SampleReflection(wo, u);
  if (!(wi.z > 0)) return std::nullopt;
  return SampleOf(wi, EvaluateConductor(wo, wi), ggx.MeanAlpha());
}

// ---- dielectric -----------------------------------------------------------------------------------------------------

BsdfValue Bsdf::EvaluateDielectric(Vec3 wo, Vec3 wi, float eta) const {
  const Ggx ggx{alpha_};
  if (wi.z > 0) {
    const GgxReflection r = EvaluateMirrored(ggx, wo, wi);
    const float fresnel = FresnelDielectric(r.cos, eta).reflectance;
    return {Rgb(r.value * fresnel), r.pdf * fresnel};
  }
  // The generalized half vector, on wo's side (Walter et al. 2007, eq. 16).
  Vec3 m = wo + wi * eta;
  const float length2 = LengthSquared(m);
  if (!(length2 > 0)) return {};
  m = m * ((m.z < 0 ? -1 : 1) / std::sqrt(length2));
  const float cos_o = Dot(wo, m), cos_i = Dot(wi, m);
  if (!(cos_o > 0 && cos_i < 0)) return {};  // microfacets seen from behind
  const float transmittance = 1 - FresnelDielectric(cos_o, eta).reflectance;
  const float ci = -wi.z, ao = ggx.Stretch(wo), ai = ggx.Stretch(wi);
  const float denominator = Sqr(cos_i + cos_o / eta);
  if (!(denominator > 0)) return {};
  // |dm / dwi| = |wi.m| / denominator.
  const float common = 2 * transmittance * ggx.Density(m) * cos_o * -cos_i / denominator;
  return {Rgb(common * ci / ((ao * ci + ai * wo.z) * (eta * eta))), common / (ao + wo.z)};
}

std::optional<BsdfSample> Bsdf::SampleDielectric(Vec3 wo, float u_lobe, Vec2 u, float eta) const {
  const Ggx ggx{alpha_};
  const Vec3 m = ggx.SampleVisible(wo, u);
  const float cos_o = Dot(wo, m);
  if (!(cos_o > 0)) return std::nullopt;
  const DielectricFresnel fresnel = FresnelDielectric(cos_o, eta);
  const float ao = ggx.Stretch(wo), visible = ggx.Density(m) / (ao + wo.z);
  if (u_lobe < fresnel.reflectance) {
    const Vec3 wi = m * (2 * cos_o) - wo;
    const float pdf = 0.5f * visible * fresnel.reflectance;
    if (!(wi.z > 0 && pdf > 0)) return std::nullopt;
    return BsdfSample{
        .wi = wi, .weight = Rgb(MaskingWeight(ao, wo.z, ggx.Stretch(wi), wi.z)), .pdf = pdf, .alpha = ggx.MeanAlpha()};
  }
  const Vec3 wi = Refract(wo, m, cos_o, fresnel.cos_t, eta);
  const float denominator = Sqr(cos_o / eta - fresnel.cos_t);
  const float pdf = 2 * visible * (1 - fresnel.reflectance) * cos_o * fresnel.cos_t / denominator;
  if (!(wi.z < 0 && denominator > 0 && pdf > 0)) return std::nullopt;
  const float weight = MaskingWeight(ao, wo.z, ggx.Stretch(wi), -wi.z) / (eta * eta);
  return BsdfSample{
      .wi = wi, .weight = Rgb(weight), .pdf = pdf, .eta = eta, .transmission = true, .alpha = ggx.MeanAlpha()};
}

}  // namespace lodestar
