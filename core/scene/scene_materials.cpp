#include "core/scene/scene_materials.h"

#include "core/base/overloaded.h"
#include "core/scene/mix_order.h"

namespace lodestar {
namespace {

Rgb Reflectance(Rgb c) {
  return Clamp(c, 0, 1);
}

// Values and textures of one material, evaluated at a point.
struct Evaluator {
  const TextureTable& textures;
  Vec2 uv;

  Rgb Color(const RgbValue& v) const { return textures.Evaluate(v, uv); }
  float Alpha(const FloatValue& v, bool remap) const {
    if (v.texture < 0) return v.value;
    const float roughness = std::clamp(textures.Evaluate(v, uv), 0.0f, 1.0f);
    return remap ? std::sqrt(roughness) : roughness;
  }
  Vec2 Alphas(const Roughness& r) const { return {Alpha(r.u, r.remap), Alpha(r.v, r.remap)}; }
  // eta and k, or those of a given reflectance at normal incidence with eta = 1.
  void Index(const ConductorMaterial& m, Rgb* eta, Rgb* k) const {
    if (!m.has_reflectance) {
      *eta = Color(m.eta);
      *k = Color(m.k);
      return;
    }
    const Rgb r = Clamp(Color(m.reflectance), 0, 0.9999f);
    *eta = Rgb(1);
    for (int c = 0; c < 3; ++c) (*k)[c] = 2 * std::sqrt(r[c]) / std::sqrt(1 - r[c]);
  }
};

// Folds every texture reference of a material and notes what is left.
struct Folder {
  const TextureTable& textures;
  MaterialTable::Traits* traits;

  void operator()(RgbValue& v) const {
    v = textures.Fold(v);
    traits->textured |= v.texture >= 0;
  }
  void operator()(FloatValue& v) const {
    v = textures.Fold(v);
    traits->textured |= v.texture >= 0;
  }
  // A constant's range and remapping are the parser's, a folded texture's ours.
  void Fold(Roughness& r) const {
    for (FloatValue* v : {&r.u, &r.v}) {
      const bool textured = v->texture >= 0;
      (*this)(*v);
      if (!textured || v->texture >= 0) continue;
      v->value = std::clamp(v->value, 0.0f, 1.0f);
      if (r.remap) v->value = std::sqrt(v->value);
    }
    const bool varies = r.u.texture >= 0 || r.v.texture >= 0;
    traits->needs_tangent |= r.u.texture != r.v.texture || r.u.value != r.v.value;
    const bool flat = std::max(r.u.value, r.v.value) < Bsdf::kSmoothAlpha;
    traits->delta |= varies || flat;
    traits->smooth |= varies || !flat;
  }
  void Fold(ConductorMaterial& m) const {
    (*this)(m.eta);
    (*this)(m.k);
    (*this)(m.reflectance);
    Fold(m.roughness);
  }
};

}  // namespace

MaterialTable::MaterialTable(const std::vector<MaterialDescription>& materials, const TextureTable& textures)
    : textures_(&textures), materials_(materials.size()) {
  for (const int i : PartsBeforeMixes(materials)) Compile(materials[i], &materials_[i]);
}

void MaterialTable::Compile(const MaterialDescription& description, Material* m) const {
  m->kind = description.kind;
  Traits& traits = m->traits;
  const Folder fold{*textures_, &traits};
  bool only_reflectance = false;  // nothing else may vary
  std::visit(Overloaded{
                 [&](DiffuseMaterial& d) {
                   fold(d.reflectance);
                   m->reflectance = d.reflectance;
                   only_reflectance = traits.smooth = true;
                 },
                 [&](ConductorMaterial& d) { fold.Fold(d); },
                 [&](DielectricMaterial& d) {
                   fold.Fold(d.roughness);
                   traits.delta |= d.eta == 1;
                   traits.transmission = true;
                 },
                 [&](ThinDielectricMaterial&) { traits.delta = traits.transmission = true; },
                 [&](CoatedDiffuseMaterial& d) {
                   fold.Fold(d.roughness);
                   const bool rough_varies = traits.textured;
                   fold(d.reflectance);
                   m->reflectance = d.reflectance;
                   only_reflectance = !rough_varies;
                   traits.smooth = true;
                 },
                 [&](CoatedConductorMaterial& d) {
                   fold.Fold(d.interface_roughness);
                   fold.Fold(d.conductor);
                 },
                 [&](DiffuseTransmissionMaterial& d) {
                   fold(d.reflectance);
                   fold(d.transmittance);
                   traits.smooth = traits.transmission = true;
                 },
                 [&](MixMaterial& d) {
                   fold(d.amount);
                   traits.mix = true;
                   for (const int part : {d.a, d.b}) {
                     const Traits& t = materials_[part].traits;
                     traits.needs_uv |= t.needs_uv;
                     traits.needs_tangent |= t.needs_tangent;
                     traits.textured |= t.textured;
                     traits.delta |= t.delta;
                     traits.smooth |= t.smooth;
                     traits.transmission |= t.transmission;
                     traits.contains_interface |= t.contains_interface || t.interface_only;
                   }
                   traits.interface_only =
                       materials_[d.a].traits.interface_only && materials_[d.b].traits.interface_only;
                   traits.contains_interface &= !traits.interface_only;
                 },
                 [&](InterfaceMaterial&) { traits.interface_only = true; },
             },
             m->kind);
  traits.needs_uv |= traits.textured;
  if (std::holds_alternative<MixMaterial>(m->kind)) {
    m->recipe = Recipe::kMix;
  } else if (!traits.textured) {
    m->recipe = Recipe::kReady;
    m->ready = Build(*m, {});
  } else if (only_reflectance) {
    m->recipe = Recipe::kReflectance;
    m->ready = Build(*m, {});
  } else {
    m->recipe = Recipe::kGeneral;
  }
}

Bsdf MaterialTable::Build(const Material& material, Vec2 uv) const {
  const Evaluator at{*textures_, uv};
  return std::visit(Overloaded{
                        [&](const DiffuseMaterial& d) { return Bsdf::Diffuse(Reflectance(at.Color(d.reflectance))); },
                        [&](const ConductorMaterial& d) {
                          Rgb eta, k;
                          at.Index(d, &eta, &k);
                          return Bsdf::Conductor(eta, k, at.Alphas(d.roughness));
                        },
                        [&](const DielectricMaterial& d) { return Bsdf::Dielectric(d.eta, at.Alphas(d.roughness)); },
                        [&](const ThinDielectricMaterial& d) { return Bsdf::ThinDielectric(d.eta); },
                        [&](const CoatedDiffuseMaterial& d) {
                          return Bsdf::CoatedDiffuse(Reflectance(at.Color(d.reflectance)), d.eta,
                                                     at.Alphas(d.roughness));
                        },
                        [&](const CoatedConductorMaterial& d) {
                          Rgb eta, k;
                          at.Index(d.conductor, &eta, &k);
                          return Bsdf::CoatedConductor(d.interface_eta, at.Alphas(d.interface_roughness), eta, k,
                                                       at.Alphas(d.conductor.roughness));
                        },
                        [&](const DiffuseTransmissionMaterial& d) {
                          return Bsdf::DiffuseTransmission(Reflectance(at.Color(d.reflectance) * d.scale),
                                                           Reflectance(at.Color(d.transmittance) * d.scale));
                        },
                        [&](const MixMaterial&) { return Bsdf::None(); },
                        [&](const InterfaceMaterial&) { return Bsdf::None(); },
                    },
                    material.kind);
}

float MaterialTable::Opacity(uint32_t material, Vec2 uv) const {
  const Material& m = materials_[material];
  if (m.traits.interface_only) return 0;
  if (!m.traits.contains_interface) return 1;
  const auto& mix = std::get<MixMaterial>(m.kind);
  const float b = std::clamp(textures_->Evaluate(mix.amount, uv), 0.0f, 1.0f);
  return (1 - b) * Opacity(mix.a, uv) + b * Opacity(mix.b, uv);
}

Bsdf MaterialTable::Cook(const Material& material, Vec2 uv, float u_mix) const {
  const Material* m = &material;
  while (m->recipe == Recipe::kMix) {
    const auto& mix = std::get<MixMaterial>(m->kind);
    float b = std::clamp(textures_->Evaluate(mix.amount, uv), 0.0f, 1.0f);
    if (m->traits.contains_interface) {
      const float in_a = (1 - b) * Opacity(mix.a, uv), in_b = b * Opacity(mix.b, uv);
      b = in_b > 0 ? in_b / (in_a + in_b) : 0;
    }
    // The number that decided is stretched to decide again.
    const bool take_b = u_mix < b;
    u_mix = std::min(take_b ? u_mix / b : (u_mix - b) / (1 - b), kOneMinusEpsilon);
    m = &materials_[take_b ? mix.b : mix.a];
  }
  switch (m->recipe) {
    case Recipe::kReady:
      return m->ready;
    case Recipe::kReflectance:
      return m->ready.WithReflectance(Reflectance(textures_->Evaluate(m->reflectance, uv)));
    default:
      return Build(*m, uv);
  }
}

}  // namespace lodestar
