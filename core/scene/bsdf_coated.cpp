// Coated materials, composed analytically from tables of what the coat's reflection lobe leaves (layering.h).
//
// Coated diffuse. With E(mu) the directional albedo of the coat's own reflection lobe,
//     f = f_interface + g(wo) g(wi) / (pi G),   g(w) = min(rho (1 - E(normal)), 1 - E(w)),   G = 2 int g(mu) mu dmu:
// the base returns g(wo), the part rho of what the coat lets in along the normal, in every direction, save where the
// lobe leaves less than that; then it returns all that is left. Reciprocal, and of albedo E(wo) + g(wo) <= 1. At rho =
// 1 it is the coupled form of Kelemen and Szirmay-Kalos 2001, of albedo 1 in every direction and at every roughness;
// their form times rho dims a base of any colour towards grazing angles, which the reference images do not show
// (docs/decisions/0005-coats.md). The lobe of a flat coat is exact Fresnel; E in the base's term is tabulated over (mu,
// alpha), G over (cap, alpha). `thickness` and `maxdepth` of pbrt-v4 have no meaning here.
//
// Coated conductor. Through a flat interface both directions refract to wo', wi', and with f_b the base's own GGX lobe
//     f = f_interface + T(wo) T(wi) / eta^2 * f_b(wo', wi') * S,   S = 1 + F K2 (1 + F K + (F K)^2 + ...)
// is exact in its first term. Approximations: (1) later reflections keep the lobe's shape, with the energies K2, K of a
// white base tabulated over wo (the geometric mean of those at wo and wi, for reciprocity), and F is Fresnel at the
// half vector of the first; (2) a rough interface widens the base's lobe: a slope s of the interface turns a refracted
// direction by (1 - 1/eta) s, twice, against 2 s for a slope of the base: alpha'^2 = alpha^2 + (1 - 1/eta)^2 alpha_c^2
// / 2; T is the rough interface's by single scattering (with 1 - E it would gain energy). Both flat: the exact series,
// one delta lobe. Against a random walk between the boundaries (gold, index 1.5): albedo within 0.02 up to 45 degrees
// under a flat coat and up to 0.12 too dark at 75; under a rough one mostly too bright, by up to 0.13
// (tests/scene/bsdf_coated_test.cpp prints the table).
#include "core/scene/bsdf.h"
#include "core/scene/fresnel.h"
#include "core/scene/microfacet.h"

namespace lodestar {
namespace {

// 1 + x + x^2 + ... per channel, x < 1.
Rgb Series(Rgb x) {
  return Rgb(1) / (Rgb(1) - x);
}

// Taken from the base per unit of anisotropy (1 - smaller alpha / larger), so that what the isotropic tables get wrong
// of an anisotropic lobe's albedo never adds up to more than 1. At 4 : 1 they are up to 0.034 too high, 0.05 too low.
constexpr float kAnisotropicLoss = 0.05f;

float Mean(Rgb c) {
  return (c.r + c.g + c.b) * (1 / 3.0f);
}

}  // namespace

void Bsdf::SetCoat(float eta, Vec2 alpha) {
  eta_ = eta;
  inverse_eta_ = 1 / eta;
  coat_flat_ = eta == 1 || Ggx::IsSmooth(alpha, kSmoothAlpha);
  alpha_ = Ggx::Clamped(alpha).alpha;
  table_ = &CoatTable::For(eta);
  const CoatTable::Row row = CoatTable::RowOf(coat_flat_ ? 0 : Ggx{alpha_}.MeanAlpha());
  coat_row_ = static_cast<uint8_t>(row.index);
  coat_row_t_ = row.t;
}

Bsdf Bsdf::CoatedDiffuse(Rgb reflectance, float eta, Vec2 alpha) {
  Bsdf b;
  b.SetCoat(eta, alpha);
  b.kind_ = b.coat_flat_ ? Kind::kSmoothCoatedDiffuse : Kind::kCoatedDiffuse;
  return b.WithReflectance(reflectance);
}

Bsdf Bsdf::WithReflectance(Rgb reflectance) const {
  Bsdf b = *this;
  b.a_ = reflectance;
  if (kind_ == Kind::kDiffuse) return b;
  b.c_ = reflectance * table_->LargestTransmittance({coat_row_, coat_row_t_});
  const Rgb mean = b.MeanCoatedBase();
  for (int i = 0; i < 3; ++i) b.b_[i] = mean[i] > 0 ? kInvPi / mean[i] : 0;
  return b;
}

Bsdf Bsdf::CoatedConductor(float interface_eta, Vec2 interface_alpha, Rgb eta, Rgb k, Vec2 alpha) {
  Bsdf b;
  b.kind_ = Kind::kCoatedConductor;
  b.SetCoat(interface_eta, interface_alpha);
  b.base_flat_ = Ggx::IsSmooth(alpha, kSmoothAlpha);
  b.a_ = eta * b.inverse_eta_;
  b.b_ = k * b.inverse_eta_;
  // A mirror is a table row of its own (row 0) even where the coat's roughness will widen its image.
  const float widening = b.coat_flat_ ? 0 : 0.5f * Sqr(1 - b.inverse_eta_);
  const Vec2 own = b.base_flat_ ? Vec2{} : Ggx::Clamped(alpha).alpha;
  b.base_alpha_ = {std::max(std::sqrt(own.x * own.x + widening * b.alpha_.x * b.alpha_.x), kSmoothAlpha),
                   std::max(std::sqrt(own.y * own.y + widening * b.alpha_.y * b.alpha_.y), kSmoothAlpha)};
  const CoatTable::Row row = CoatTable::RowOf(Ggx{b.base_alpha_}.MeanAlpha());
  b.base_row_ = static_cast<uint8_t>(row.index);
  b.base_row_t_ = row.t;
  // Not zero where Fresnel is: it grows towards grazing angles.
  b.base_energy_ = std::max(Mean(FresnelConductor(0.9f, b.a_, b.b_)), 0.05f);
  return b;
}

float Bsdf::CoatTransmittance(Vec3 w) const {
  CoatTable::Row row{coat_row_, coat_row_t_};
  if (kind_ == Kind::kCoatedConductor) return table_->SingleScatterTransmittance(w.z, row);
  if (kind_ == Kind::kCoatedDiffuse && alpha_.x != alpha_.y) {
    // The roughness that w meets: along its azimuth at grazing angles, the mean of both along the normal.
    row = CoatTable::RowOf(std::sqrt(Sqr(alpha_.x * w.x) + Sqr(alpha_.y * w.y) + alpha_.x * alpha_.y * Sqr(w.z)));
  }
  return table_->Transmittance(w.z, row);
}

// G, a little above it for anisotropic coats.
Rgb Bsdf::MeanCoatedBase() const {
  if (coat_flat_ || alpha_.x == alpha_.y) {
    const CoatTable::Row row{coat_row_, coat_row_t_};
    return {table_->MeanTransmittance(row, c_.r), table_->MeanTransmittance(row, c_.g),
            table_->MeanTransmittance(row, c_.b)};
  }
  constexpr int kPhis = 4, kMus = 8;  // midpoints in a quadrant, and in mu^2
  Rgb sum;
  for (int i = 0; i < kPhis * kMus; ++i) {
    const float mu2 = (static_cast<float>(i / kPhis) + 0.5f) / kMus, sin = std::sqrt(1 - mu2);
    const auto [y, x] = SinCos((static_cast<float>(i % kPhis) + 0.5f) * (kPi / 2 / kPhis));
    sum += CoatedBase(CoatTransmittance({sin * x, sin * y, std::sqrt(mu2)}));
  }
  const float anisotropy = 1 - std::min(alpha_.x, alpha_.y) / std::max(alpha_.x, alpha_.y);
  return sum / (kPhis * kMus * (1 - kAnisotropicLoss * anisotropy));
}

Bsdf::CoatState Bsdf::CoatAt(Vec3 wo) const {
  CoatState state;
  // The table stands in for the flat interface too: it differs by less than 1e-3 and spares a Fresnel term.
  state.transmittance = CoatTransmittance(wo);
  state.reflectance = eta_ == 1    ? 0
                      : coat_flat_ ? FresnelDielectric(wo.z, eta_).reflectance
                                   : std::max(1 - state.transmittance, 0.0f);
  const float lobe = state.reflectance;
  const float base =
      kind_ == Kind::kCoatedConductor ? state.transmittance * base_energy_ : Mean(CoatedBase(state.transmittance));
  state.lobe_probability = lobe > 0 ? lobe / (lobe + base) : 0;
  // A base that reflects at all stays within reach, or its value would have no density at grazing angles.
  if (base > 0) state.lobe_probability = std::min(state.lobe_probability, 0.999f);
  return state;
}

BsdfSample Bsdf::SampleFlatCoat(Vec3 wo, const CoatState& state) {
  return MirrorSample(wo, Rgb(state.reflectance / state.lobe_probability), state.lobe_probability);
}

BsdfValue Bsdf::CoatLobe(Vec3 wo, Vec3 wi) const {
  const GgxReflection r = EvaluateReflection(Ggx{alpha_}, wo, wi);
  return {Rgb(r.value * FresnelDielectric(r.cos, eta_).reflectance), r.pdf};
}

// ---- coated diffuse -------------------------------------------------------------------------------------------------

BsdfValue Bsdf::EvaluateCoatedDiffuse(Vec3 wo, Vec3 wi, const CoatState& state) const {
  BsdfValue value{b_ * CoatedBase(state.transmittance) * CoatedBase(CoatTransmittance(wi)) * wi.z,
                  (1 - state.lobe_probability) * wi.z * kInvPi};
  if (!coat_flat_) {
    const BsdfValue lobe = CoatLobe(wo, wi);
    value.f_cos += lobe.f_cos;
    value.pdf += state.lobe_probability * lobe.pdf;
  }
  return value;
}

std::optional<BsdfSample> Bsdf::SampleCoatedDiffuse(Vec3 wo, float u_lobe, Vec2 u) const {
  const CoatState state = CoatAt(wo);
  const bool coat = u_lobe < state.lobe_probability;
  if (coat && coat_flat_) return SampleFlatCoat(wo, state);
  const Ggx ggx{alpha_};
  const Vec3 wi = coat ? ggx.SampleReflection(wo, u) : SquareToCosineHemisphere(u);
  if (!(wi.z > 0)) return std::nullopt;
  return SampleOf(wi, EvaluateCoatedDiffuse(wo, wi, state), coat ? ggx.MeanAlpha() : 1);
}

// ---- coated conductor -----------------------------------------------------------------------------------------------

Rgb Bsdf::FlatCoatedConductorReflectance(float cos_o) const {
  const DielectricFresnel fresnel = FresnelDielectric(cos_o, eta_);
  if (fresnel.reflectance >= 1) return Rgb(1);
  const Rgb base = FresnelConductor(fresnel.cos_t, a_, b_);
  return Rgb(fresnel.reflectance) + base * Series(base * fresnel.reflectance) * Sqr(1 - fresnel.reflectance);
}

BsdfValue Bsdf::EvaluateCoatedConductor(Vec3 wo, Vec3 wi, const CoatState& state) const {
  BsdfValue value;
  if (!coat_flat_) {
    value = CoatLobe(wo, wi);
    value.pdf *= state.lobe_probability;
  }
  const Vec3 o = AcrossFlatInterface(wo, eta_), i = AcrossFlatInterface(wi, eta_);
  if (!(o.z > 0 && i.z > 0)) return value;
  const float transmittance_i = CoatTransmittance(wi);
  const GgxReflection r = EvaluateReflection(Ggx{base_alpha_}, o, i);  // value = D G2 / (4 co ci) * i.z
  const Rgb fresnel = FresnelConductor(r.cos, a_, b_);
  const CoatTable::Row row{base_row_, base_row_t_};
  const float second = std::sqrt(table_->SecondBounce(wo.z, row) * table_->SecondBounce(wi.z, row));
  const float later = std::sqrt(table_->LaterBounces(wo.z, row) * table_->LaterBounces(wi.z, row));
  const Rgb series = Rgb(1) + fresnel * second * Series(fresnel * later);
  // cos dwi = eta^2 cos' dwi'.
  const float jacobian = wi.z / (i.z * eta_ * eta_);
  value.f_cos += fresnel * series * (state.transmittance * transmittance_i * r.value * jacobian);
  value.pdf += (1 - state.lobe_probability) * r.pdf * jacobian;
  return value;
}

std::optional<BsdfSample> Bsdf::SampleCoatedConductor(Vec3 wo, float u_lobe, Vec2 u) const {
  if (coat_flat_ && base_flat_) {
    return MirrorSample(wo, FlatCoatedConductorReflectance(wo.z), 1);
  }
  const CoatState state = CoatAt(wo);
  const bool coat = u_lobe < state.lobe_probability;
  if (coat && coat_flat_) return SampleFlatCoat(wo, state);
  Vec3 wi;
  if (coat) {
    wi = Ggx{alpha_}.SampleReflection(wo, u);
  } else {
    const Vec3 o = AcrossFlatInterface(wo, eta_);
    if (!(o.z > 0)) return std::nullopt;
    const Vec3 i = Ggx{base_alpha_}.SampleReflection(o, u);
    if (!(i.z > 0)) return std::nullopt;
    wi = AcrossFlatInterface(i, inverse_eta_);
  }
  if (!(wi.z > 0)) return std::nullopt;
  return SampleOf(wi, EvaluateCoatedConductor(wo, wi, state), Ggx{coat ? alpha_ : ApparentBaseAlpha()}.MeanAlpha());
}

}  // namespace lodestar
