// Lights. Strengths follow pbrt-v4: an rgb spectrum is taken as it is, any other spectrum has the luminance 1; "scale"
// multiplies. "power" and "illuminance" are what a spectrum of luminance 1 gives: an rgb multiplies them as it does the
// light, and so does "scale".
#include <cmath>

#include "core/math/elementary.h"
#include "core/scene/mix_order.h"
#include "core/scene/pbrt_builder.h"

namespace lodestar {
namespace {

// `emitted` is what a light of luminance 1 gives in the unit of the parameter. Returns the factor for the spectrum.
Rgb WithStrength(PbrtParams& params, Rgb spectrum, std::string_view name, float emitted) {
  const float scale = params.NonNegativeFloat("scale", 1);
  const auto wanted = params.FindFloat(name);
  if (!wanted) return spectrum * scale;
  const PbrtParam& param = *params.Find(name, {"float"});
  if (!(*wanted > 0)) params.Fail(param, "must be greater than 0");
  if (!(Luminance(spectrum) > 0)) params.Fail(param, "needs a spectrum that is not black");
  return spectrum * (scale * *wanted / emitted);
}

float Cosine(float degrees) {
  return SinCos(Radians(degrees)).cos;
}

}  // namespace

void PbrtBuilder::AreaLightSource(const Token& directive) {
  InWorld(directive);
  const std::string type = NeedString("an area light's type");
  PbrtParams params = Params(directive, type, "light");
  if (type != "diffuse") UnknownType(directive, type, "diffuse");
  AreaLightDescription light;
  light.where = directive.where();
  const float scale = params.NonNegativeFloat("scale", 1);
  const Rgb spectrum = LightSpectrum(params, "L");
  light.radiance = spectrum * scale;
  light.two_sided = params.Bool("twosided", false);
  if (const auto power = params.FindFloat("power")) {
    const PbrtParam& param = *params.Find("power", {"float"});
    if (!(*power > 0)) params.Fail(param, "must be greater than 0");
    if (!(Luminance(spectrum) > 0)) params.Fail(param, "needs a spectrum that is not black");
    light.radiance = spectrum;
    light.power = *power * scale;
  }
  params.Refuse({"filename"}, "light from an image is not");
  params.Finish();
  state_.area_light = light;
}

// At the end, since a material may be defined after its use.
void PbrtBuilder::CheckLights() {
  std::vector<bool> interface(scene_.materials.size());  // or a mix with one somewhere in it
  for (const int i : PartsBeforeMixes(scene_.materials)) {
    const auto& kind = scene_.materials[i].kind;
    const auto* mix = std::get_if<MixMaterial>(&kind);
    interface[i] = mix ? interface[mix->a] || interface[mix->b] : std::holds_alternative<InterfaceMaterial>(kind);
  }
  for (ShapeDescription& shape : scene_.shapes) {
    if (!shape.light || !interface[shape.material]) continue;
    refusals_.Refuse(shape.where,
                     "a light on a shape of the material \"interface\", or of a mix with it, is not supported: there "
                     "is no surface that could emit");
    shape.light.reset();
  }
}

void PbrtBuilder::LightSource(const Token& directive) {
  InWorld(directive);
  const std::string type = NeedString("a light's type");
  PbrtParams params = Params(directive, type, "light");
  if (type == "goniometric" || type == "projection")
    return refusals_.Refuse(directive.where(),
                            params.label() + " is not supported; use point, spot, distant or infinite");
  LightDescription light;
  light.where = directive.where();
  light.world_from_light = state_.ctm;
  const auto aim = [&](Vec3 from, Vec3 to) {
    if (from == to)
      FailAt(params.where(), ErrorKind::kInvalidInput, params.label() + ": \"from\" and \"to\" are the same point");
  };
  if (type == "point") {
    PointLight point;
    point.intensity = WithStrength(params, LightSpectrum(params, "I"), "power", 4 * kPi);
    point.from = state_.ctm.Point(params.Point("from", {0, 0, 0}));
    light.kind = point;
  } else if (type == "spot") {
    SpotLight spot;
    const Vec3 from = params.Point("from", {0, 0, 0}), to = params.Point("to", {0, 0, 1});
    aim(from, to);
    spot.from = state_.ctm.Point(from);
    spot.to = state_.ctm.Point(to);
    spot.cone_angle = params.PositiveFloat("coneangle", 30);
    spot.cone_delta = params.NonNegativeFloat("conedeltaangle", 5);
    if (spot.cone_angle > 180) params.Fail(*params.Find("coneangle", {"float"}), "must not exceed 180 degrees");
    if (spot.cone_delta > spot.cone_angle)
      FailAt(params.where(), ErrorKind::kInvalidInput,
             params.label() + ": \"conedeltaangle\" must not exceed \"coneangle\"");
    // Full intensity inside, and a smooth step (mean 1/2 over the cosine) to the edge.
    const float edge = Cosine(spot.cone_angle), full = Cosine(spot.cone_angle - spot.cone_delta);
    spot.intensity =
        WithStrength(params, LightSpectrum(params, "I"), "power", 2 * kPi * ((1 - full) + (full - edge) / 2));
    light.kind = spot;
  } else if (type == "distant") {
    DistantLight distant;
    const Vec3 from = params.Point("from", {0, 0, 0}), to = params.Point("to", {0, 0, 1});
    aim(from, to);
    distant.to_light = Normalize(state_.ctm.Vector(from - to));
    distant.radiance = WithStrength(params, LightSpectrum(params, "L"), "illuminance", 1);
    light.kind = distant;
  } else if (type == "infinite") {
    InfiniteLight infinite;
    if (const PbrtParam* file = params.Find("filename", {"string"})) {
      if (const PbrtParam* l = params.Find("L", {"rgb", "spectrum", "blackbody"}))
        params.Fail(*l, "cannot be combined with \"filename\"; use \"scale\"");
      infinite.path = NeedFile(params, *file, params.String("filename", ""));
      infinite.radiance = Rgb(params.NonNegativeFloat("scale", 1));
      if (const auto illuminance = params.FindFloat("illuminance")) {
        if (!(*illuminance > 0)) params.Fail(*params.Find("illuminance", {"float"}), "must be greater than 0");
        infinite.illuminance = *illuminance;
      }
    } else {
      infinite.radiance = WithStrength(params, LightSpectrum(params, "L"), "illuminance", kPi);
    }
    params.Refuse({"portal"}, "the whole environment is sampled");
    light.kind = infinite;
  } else {
    UnknownType(directive, type, "point, spot, distant, infinite");
  }
  params.Finish();
  if (current_object_ >= 0)
    return refusals_.Refuse(
        directive.where(),
        params.label() + " inside an object definition is not supported: lights cannot be instanced");
  scene_.lights.push_back(std::move(light));
}

}  // namespace lodestar
