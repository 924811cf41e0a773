#include <cmath>

#include "core/scene/mix_order.h"
#include "core/scene/pbrt_builder.h"

namespace lodestar {
namespace {

constexpr const char* kSupported =
    "diffuse, conductor, dielectric, thindielectric, coateddiffuse, coatedconductor, diffusetransmission, mix, "
    "interface";

bool IsUnsupportedMaterial(std::string_view type) {
  for (std::string_view name : {"subsurface", "hair", "measured"})
    if (type == name) return true;
  return false;
}

}  // namespace

Roughness PbrtBuilder::ReadRoughness(PbrtParams& params, const std::string& prefix, bool remap) {
  const auto alpha = [&](const std::string& name) {
    FloatValue value = FloatParam(params, name, 0);
    if (value.texture >= 0) return value;
    if (value.value < 0) params.Fail(*params.Find(name, {"float"}), "must not be negative");
    if (value.value > 1) {
      params.Refuse({name}, "roughness ends at 1");
      value.value = 1;  // lenient
    }
    // pbrt-v4's remapping: alpha is the square root of the roughness.
    if (remap) value.value = std::sqrt(value.value);
    return value;
  };
  const FloatValue both = alpha(prefix + "roughness");
  const auto axis = [&](const std::string& name) {
    return params.Find(name, {"float", "texture"}) ? alpha(name) : both;
  };
  return {axis(prefix + "uroughness"), axis(prefix + "vroughness"), remap};
}

ConductorMaterial PbrtBuilder::Conductor(PbrtParams& params, const std::string& prefix,
                                         const std::string& roughness_prefix, bool remap) {
  ConductorMaterial conductor;
  if (const PbrtParam* reflectance = params.Find("reflectance", {"rgb", "spectrum", "texture"})) {
    for (const std::string& name : {prefix + "eta", prefix + "k"})
      if (const PbrtParam* other = params.Find(name, {"rgb", "spectrum", "texture"}))
        params.Fail(*other, "cannot be combined with \"reflectance\" (at " + reflectance->where.ToString() + ")");
    conductor.has_reflectance = true;
    conductor.reflectance = RgbParam(params, "reflectance", Rgb(1), true);
  }
  const std::string copper = "metal-Cu-";
  conductor.eta = RgbParam(params, prefix + "eta", *NamedSurfaceSpectrum(copper + "eta"), false);
  conductor.k = RgbParam(params, prefix + "k", *NamedSurfaceSpectrum(copper + "k"), false);
  conductor.roughness = ReadRoughness(params, roughness_prefix, remap);
  return conductor;
}

MixMaterial PbrtBuilder::Mix(PbrtParams& params) {
  const PbrtParam* names = params.Find("materials", {"string"});
  if (!names)
    FailAt(params.where(), ErrorKind::kInvalidInput, params.label() + " needs \"string materials\" with two names");
  if (names->strings.size() != 2) params.Fail(*names, "takes two names, not " + std::to_string(names->strings.size()));
  MixMaterial mix;
  mix.a = NamedMaterialIndex(names->strings[0], names->where);
  mix.b = NamedMaterialIndex(names->strings[1], names->where);
  mix.amount = FloatParam(params, "amount", 0.5f);
  if (mix.amount.texture < 0 && !(mix.amount.value >= 0 && mix.amount.value <= 1))
    params.Fail(*params.Find("amount", {"float"}), "must be between 0 and 1");
  return mix;
}

PbrtBuilder::MaterialKind PbrtBuilder::ReadMaterial(const std::string& type, const Token& directive,
                                                    PbrtParams& params) {
  if (IsUnsupportedMaterial(type)) {
    refusals_.Refuse(directive.where(), params.label() + " is not supported; use one of: " + kSupported);
    return DiffuseMaterial{};  // lenient: a stand-in
  }
  MaterialKind kind;
  const bool interface = type == "interface" || type == "none" || type.empty();  // the last two are its older names
  const bool remap = params.Bool("remaproughness", true);
  // diffusetransmission has no roughness either, but pbrt-v4 reads it there.
  const bool reads_remap = type == "conductor" || type == "dielectric" || type == "coateddiffuse" ||
                           type == "coatedconductor" || type == "diffusetransmission";
  if (const PbrtParam* unwanted = reads_remap ? nullptr : params.Find("remaproughness", {"bool"});
      unwanted && !unwanted->inherited)
    params.Fail(*unwanted, "is not used: it has no roughness");
  if (type == "diffuse") {
    kind = DiffuseMaterial{RgbParam(params, "reflectance", Rgb(0.5f), true)};
  } else if (type == "conductor") {
    kind = Conductor(params, "", "", remap);
  } else if (type == "dielectric") {
    kind = DielectricMaterial{Eta(params, "eta", 1.5f), ReadRoughness(params, "", remap)};
  } else if (type == "thindielectric") {
    kind = ThinDielectricMaterial{Eta(params, "eta", 1.5f)};
  } else if (type == "coateddiffuse") {
    kind = CoatedDiffuseMaterial{RgbParam(params, "reflectance", Rgb(0.5f), true), Eta(params, "eta", 1.5f),
                                 ReadRoughness(params, "", remap)};
  } else if (type == "coatedconductor") {
    CoatedConductorMaterial coated;
    coated.interface_eta = Eta(params, "interface.eta", 1.5f);
    coated.interface_roughness = ReadRoughness(params, "interface.", remap);
    coated.conductor = Conductor(params, "conductor.", "conductor.", remap);
    kind = coated;
  } else if (type == "diffusetransmission") {
    DiffuseTransmissionMaterial thin;
    thin.reflectance = RgbParam(params, "reflectance", Rgb(0.25f), true);
    thin.transmittance = RgbParam(params, "transmittance", Rgb(0.25f), true);
    thin.scale = params.NonNegativeFloat("scale", 1);
    kind = thin;
  } else if (type == "mix") {
    kind = Mix(params);
  } else if (interface) {
    kind = InterfaceMaterial{};
  } else {
    UnknownType(directive, type, kSupported);
  }
  if (type == "coateddiffuse" || type == "coatedconductor") {
    // The layering here is analytic, so these do not matter. In pbrt-v4 a coat absorbs by its thickness, though it has
    // no medium: 2 % of what passes at the default, which is neglected here, and 86 % at 1.
    params.Accept({"maxdepth", "nsamples", "g"});
    const char* absorbs = "a coat of it absorbs";
    params.RefuseUnless("thickness", {0.01f}, absorbs);
    if (type == "coatedconductor") params.RefuseUnless("interface.thickness", {0.01f}, absorbs);
    if (const PbrtParam* albedo = params.Find("albedo", {"rgb", "spectrum", "texture"}))
      if (albedo->type == "texture" || !IsBlack(SurfaceSpectrum(params, *albedo, true)))
        params.Refuse({"albedo"}, "there is no medium between the layers; only 0 is");
  }
  if (type != "mix" && !interface)
    params.Refuse({"displacement", "normalmap"}, "surfaces are shaded as their geometry is");
  params.Finish();
  return kind;
}

void PbrtBuilder::Material(const Token& directive) {
  InWorld(directive);
  const std::string type = NeedString("a material's type");
  PbrtParams params = Params(directive, type, "material");
  MaterialKind kind = ReadMaterial(type, directive, params);
  state_.material = static_cast<int>(scene_.materials.size());
  scene_.materials.push_back({"", std::move(kind), directive.where()});
}

// A name may be used before it is defined: its place is taken at first sight and filled by MakeNamedMaterial.
int PbrtBuilder::NamedMaterialIndex(const std::string& name, const SourceLocation& where) {
  const auto [entry, is_new] =
      named_materials_.try_emplace(name, NamedMaterialEntry{static_cast<int>(scene_.materials.size()), false, where});
  if (is_new) scene_.materials.push_back({name, DiffuseMaterial{}, where});
  return entry->second.index;
}

void PbrtBuilder::NamedMaterial(const Token& directive) {
  InWorld(directive);
  state_.material = NamedMaterialIndex(NeedString("a material's name"), directive.where());
}

void PbrtBuilder::MakeNamedMaterial(const Token& directive) {
  InWorld(directive);
  const std::string name = NeedString("a material's name");
  PbrtParams params = Params(directive, name, "material");
  const auto type = params.FindString("type");
  if (!type || type->empty())
    FailAt(directive.where(), ErrorKind::kInvalidInput, params.label() + " needs a \"string type\"");
  const int index = NamedMaterialIndex(name, directive.where());
  NamedMaterialEntry& entry = named_materials_.at(name);
  if (entry.defined)
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "a material \"" + name + "\" is defined already, at " + scene_.materials[index].where.ToString());
  entry.defined = true;
  MaterialKind kind = ReadMaterial(*type, directive, params);
  scene_.materials[index] = {name, std::move(kind), directive.where()};
}

void PbrtBuilder::CheckMaterials() const {
  for (const auto& [name, entry] : named_materials_)
    if (!entry.defined)
      FailAt(entry.first_use, ErrorKind::kInvalidInput,
             "material \"" + name + "\" is used, but no MakeNamedMaterial defines it");
  PartsBeforeMixes(scene_.materials);  // throws where there is no such order
}

}  // namespace lodestar
