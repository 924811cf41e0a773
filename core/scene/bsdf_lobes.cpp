// What a BSDF tells of its lobes without evaluating them: albedos and shares, approximate.
#include "core/scene/bsdf.h"
#include "core/scene/fresnel.h"
#include "core/scene/microfacet.h"

namespace lodestar {

Rgb Bsdf::Albedo(Vec3 wo) const {
  const float mu = std::fabs(wo.z);
  switch (kind_) {
    case Kind::kDiffuse:
      return a_;
    case Kind::kConductor:
    case Kind::kSmoothConductor:
      return FresnelConductor(mu, a_, b_);
    case Kind::kDielectric:
    case Kind::kSmoothDielectric:
    case Kind::kThinDielectric:
      return Rgb(1);
    case Kind::kDiffuseTransmission:
      return a_ + b_;
    case Kind::kCoatedDiffuse:
    case Kind::kSmoothCoatedDiffuse: {
      const CoatState state = CoatAt({wo.x, wo.y, mu});
      return Rgb(state.reflectance) + CoatedBase(state.transmittance);
    }
    case Kind::kCoatedConductor:
      return FlatCoatedConductorReflectance(mu);
    case Kind::kNone:
      break;
  }
  return Rgb(0);
}

BsdfLobes Bsdf::Lobes(Vec3 wo) const {
  const float mu = std::fabs(wo.z);
  BsdfLobes result;
  float scattered = 0;  // luminance of everything, delta lobes too
  const auto scatter = [&](float luminance) { scattered += luminance; };
  const auto add = [&](BsdfLobe::Kind kind, Vec2 alpha, float luminance) {
    scattered += luminance;
    if (luminance > 0) result.lobes[result.count++] = {kind, alpha, luminance};
  };
  switch (kind_) {
    case Kind::kDiffuse:
      add(BsdfLobe::Kind::kDiffuseReflection, {}, Luminance(a_));
      break;
    case Kind::kConductor:
      add(BsdfLobe::Kind::kGgxReflection, alpha_, Luminance(FresnelConductor(mu, a_, b_)));
      break;
    case Kind::kDielectric: {
      const float reflectance = FresnelDielectric(mu, wo.z < 0 ? inverse_eta_ : eta_).reflectance;
      add(BsdfLobe::Kind::kGgxReflection, alpha_, reflectance);
      scatter(1 - reflectance);
      break;
    }
    case Kind::kDiffuseTransmission:
      add(BsdfLobe::Kind::kDiffuseReflection, {}, Luminance(a_));
      add(BsdfLobe::Kind::kDiffuseTransmission, {}, Luminance(b_));
      break;
    case Kind::kCoatedDiffuse:
    case Kind::kSmoothCoatedDiffuse: {
      const CoatState state = CoatAt({wo.x, wo.y, mu});
      if (coat_flat_) {
        scatter(state.reflectance);
      } else {
        add(BsdfLobe::Kind::kGgxReflection, alpha_, state.reflectance);
      }
      add(BsdfLobe::Kind::kDiffuseReflection, {}, Luminance(CoatedBase(state.transmittance)));
      break;
    }
    case Kind::kCoatedConductor: {
      const float coat = FresnelDielectric(mu, eta_).reflectance;
      const float base = Luminance(FlatCoatedConductorReflectance(mu)) - coat;
      if (coat_flat_) {
        scatter(coat);
      } else {
        add(BsdfLobe::Kind::kGgxReflection, alpha_, coat);
      }
      if (HasSmoothLobes()) add(BsdfLobe::Kind::kGgxReflection, ApparentBaseAlpha(), base);
      break;
    }
    case Kind::kSmoothConductor:
    case Kind::kSmoothDielectric:
    case Kind::kThinDielectric:
    case Kind::kNone:
      break;
  }
  for (int i = 0; i < result.count; ++i) result.lobes[i].weight /= scattered;
  return result;
}

float Bsdf::AlphaAt(Vec3 wo, Vec3 wi) const {
  switch (kind_) {
    case Kind::kConductor:
    case Kind::kDielectric:  // reflection and refraction alike
      return Ggx{alpha_}.MeanAlpha();
    case Kind::kCoatedDiffuse:
    case Kind::kCoatedConductor: {
      if (!(wo.z * wi.z > 0)) return 1;
      wo.z = std::fabs(wo.z);
      wi.z = std::fabs(wi.z);
      float greatest = 0, alpha = 1;
      for (const BsdfLobe& lobe : Lobes(wo)) {
        const bool ggx = lobe.kind == BsdfLobe::Kind::kGgxReflection;
        const float density = lobe.weight * (ggx ? EvaluateMirrored(Ggx{lobe.alpha}, wo, wi).pdf : wi.z * kInvPi);
        if (!(density > greatest)) continue;
        greatest = density;
        alpha = ggx ? Ggx{lobe.alpha}.MeanAlpha() : 1;
      }
      return alpha;
    }
    default:
      return 1;
  }
}

// Leaving the coat multiplies the tangential parts of directions by eta, and so the spread of the base's lobe.
Vec2 Bsdf::ApparentBaseAlpha() const {
  return {std::min(base_alpha_.x * eta_, 1.0f), std::min(base_alpha_.y * eta_, 1.0f)};
}

}  // namespace lodestar
