// What stands before WorldBegin: how to render.
#include <algorithm>

#include "core/base/picture_size.h"
#include "core/scene/pbrt_builder.h"

namespace lodestar {
namespace {

bool IsOneOf(std::string_view text, std::initializer_list<std::string_view> list) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

}  // namespace

void PbrtBuilder::Integrator(const Token& directive) {
  BeforeWorld(directive);
  const std::string type = NeedString("an integrator's name");
  PbrtParams params = Params(directive, type);
  if (IsOneOf(type, {"ambientocclusion", "function"}))
    return refusals_.Refuse(directive.where(),
                            params.label() + " is not supported: it computes another image than light transport");
  // All of these estimate the same image; the method is chosen on the command line.
  if (!IsOneOf(type,
               {"path", "volpath", "simplepath", "simplevolpath", "bdpt", "mlt", "sppm", "lightpath", "randomwalk"}))
    UnknownType(
        directive, type,
        "path, volpath, simplepath, simplevolpath, bdpt, mlt, sppm, lightpath, randomwalk (only \"maxdepth\" is used)");
  scene_.max_depth = params.Int("maxdepth", 5);
  if (scene_.max_depth < 0)
    FailAt(params.where(), ErrorKind::kInvalidInput,
           "\"integer maxdepth\" of " + params.label() + " must not be negative");
  params.RefuseUnless("regularize", false, "it changes the image");
  params.RefuseUnless("visualizestrategies", false, "a debugging aid of pbrt");
  params.RefuseUnless("visualizeweights", false, "a debugging aid of pbrt");
  params.Accept({"lightsampler", "samplelights", "samplebsdf"});
  if (type == "mlt")
    params.Accept({"bootstrapsamples", "chains", "mutationsperpixel", "largestepprobability", "sigma"});
  if (type == "sppm") params.Accept({"photonsperiteration", "radius", "seed"});
  params.Finish();
}

void PbrtBuilder::Sampler(const Token& directive) {
  BeforeWorld(directive);
  const std::string type = NeedString("a sampler's name");
  if (!IsOneOf(type, {"halton", "independent", "paddedsobol", "sobol", "stratified", "zsobol", "pmj02bn"}))
    UnknownType(
        directive, type,
        "halton, independent, paddedsobol, sobol, stratified, zsobol, pmj02bn (only the number of samples is used)");
  PbrtParams params = Params(directive, type);
  if (type == "stratified") {
    const int x = params.Int("xsamples", 4), y = params.Int("ysamples", 4);
    if (x <= 0 || y <= 0 || x > (1 << 30) / y)
      FailAt(params.where(), ErrorKind::kInvalidInput,
             params.label() + ": xsamples and ysamples must be greater than 0");
    scene_.samples_per_pixel = x * y;
    params.Accept({"jitter"});
  } else {
    scene_.samples_per_pixel = params.Int("pixelsamples", 16);
    if (scene_.samples_per_pixel <= 0)
      FailAt(params.where(), ErrorKind::kInvalidInput,
             "\"integer pixelsamples\" of " + params.label() + " must be greater than 0");
  }
  params.Accept({"randomization", "seed"});
  params.Finish();
}

void PbrtBuilder::PixelFilter(const Token& directive) {
  BeforeWorld(directive);
  const std::string type = NeedString("a filter's name");
  PbrtParams params = Params(directive, type);
  if (type == "sinc") return refusals_.Refuse(directive.where(), params.label() + " is not supported; use mitchell");
  using Kind = PixelFilterDescription::Kind;
  PixelFilterDescription filter;
  if (type == "box") {
    filter.kind = Kind::kBox;
    filter.radius_x = filter.radius_y = 0.5f;
  } else if (type == "triangle") {
    filter.kind = Kind::kTriangle;
    filter.radius_x = filter.radius_y = 2;
  } else if (type == "gaussian") {
    filter.kind = Kind::kGaussian;
    filter.radius_x = filter.radius_y = 1.5f;
    filter.sigma = params.PositiveFloat("sigma", 0.5f);
  } else if (type == "mitchell") {
    filter.kind = Kind::kMitchell;
    filter.radius_x = filter.radius_y = 2;
    filter.b = params.Float("B", 1 / 3.0f);
    filter.c = params.Float("C", 1 / 3.0f);
  } else {
    UnknownType(directive, type, "box, triangle, gaussian, mitchell");
  }
  filter.radius_x = params.PositiveFloat("xradius", filter.radius_x);
  filter.radius_y = params.PositiveFloat("yradius", filter.radius_y);
  params.Finish();
  scene_.filter = filter;
}

void PbrtBuilder::Film(const Token& directive) {
  BeforeWorld(directive);
  const std::string type = NeedString("a film's name");
  if (!IsOneOf(type, {"rgb", "gbuffer", "spectral"})) UnknownType(directive, type, "rgb");
  PbrtParams params = Params(directive, type);
  const int x = params.Int("xresolution", 1280), y = params.Int("yresolution", 720);
  if (!CanBeRendered(x, y))
    FailAt(params.where(), ErrorKind::kInvalidInput,
           params.label() + ": the resolution " + std::to_string(x) + " x " + std::to_string(y) +
               " cannot be rendered; " + PictureSizeRule());
  scene_.resolution_x = x;
  scene_.resolution_y = y;
  if (type == "spectral")
    refusals_.Refuse(directive.where(), params.label() + " is not supported; use rgb (rendering is in linear sRGB)");
  // The output's name and its auxiliary layers are given on the command line; the sensor's size only serves cameras
  // that are not supported.
  params.Accept({"filename", "diagonal", "savefp16"});
  if (type == "gbuffer") params.Accept({"coordinatesystem"});
  if (type == "spectral") params.Accept({"nbuckets", "lambdamin", "lambdamax"});
  params.RefuseUnless("cropwindow", {0, 1, 0, 1}, "it changes the image");
  params.Refuse({"pixelbounds", "maxcomponentvalue"}, "it changes the image");
  params.RefuseUnless("exposuretime", {1}, "it changes the image");
  params.RefuseUnless("whitebalance", {0}, "it changes the image");
  if (params.String("sensor", "cie1931") != "cie1931") params.Refuse({"sensor"}, "only cie1931 is");
  iso_ = params.PositiveFloat("iso", 100);
  params.Finish();
}

void PbrtBuilder::Camera(const Token& directive) {
  BeforeWorld(directive);
  const std::string type = NeedString("a camera's name");
  if (!IsOneOf(type, {"perspective", "orthographic", "realistic", "spherical"}))
    UnknownType(directive, type, "perspective");
  PbrtParams params = Params(directive, type);
  CameraDescription camera;
  camera.camera_from_world = state_.ctm;
  coordinate_systems_["camera"] = state_.ctm.Inverse();
  const float open = params.Float("shutteropen", 0), close = params.Float("shutterclose", 1);
  if (!(close > open))
    FailAt(params.where(), ErrorKind::kInvalidInput,
           params.label() + ": \"shutterclose\" must be later than \"shutteropen\": what is between is the exposure");
  exposure_seconds_ = close - open;
  if (type != "perspective") {
    refusals_.Refuse(directive.where(), params.label() + " is not supported; use perspective");
    scene_.camera = camera;
    return;
  }
  camera.fov = params.Float("fov", 90);
  if (!(camera.fov > 0 && camera.fov < 180))
    FailAt(params.where(), ErrorKind::kInvalidInput,
           "\"float fov\" of " + params.label() + " must be between 0 and 180 degrees");
  camera.lens_radius = params.NonNegativeFloat("lensradius", 0);
  camera.focal_distance = params.PositiveFloat("focaldistance", 1e6f);
  if (params.Find("frameaspectratio", {"float"})) {
    const float aspect = params.PositiveFloat("frameaspectratio", 1);
    camera.screen_window =
        aspect > 1 ? std::array{-aspect, aspect, -1.0f, 1.0f} : std::array{-1.0f, 1.0f, -1 / aspect, 1 / aspect};
  }
  const std::vector<float> window = params.Floats("screenwindow");
  if (params.Find("screenwindow", {"float"})) {
    if (window.size() != 4 || !(window[0] < window[1]) || !(window[2] < window[3]))
      FailAt(params.where(), ErrorKind::kInvalidInput,
             "\"float screenwindow\" of " + params.label() + " takes four numbers: x0 < x1, y0 < y1");
    std::copy(window.begin(), window.end(), camera.screen_window.begin());
  }
  params.Finish();
  scene_.camera = camera;
}

// pbrt-v4's film measures exposure time * iso / 100 of the light that falls on it (its PixelSensor's imaging ratio).
// The lights are made so much stronger, once both directives are known.
void PbrtBuilder::Expose() {
  const float ratio = exposure_seconds_ * iso_ / 100;
  for (ShapeDescription& shape : scene_.shapes) {
    if (!shape.light) continue;
    if (shape.light->power > 0)
      shape.light->power *= ratio;
    else
      shape.light->radiance *= ratio;
  }
  for (LightDescription& light : scene_.lights) {
    const auto scale = [ratio](auto& kind) {
      if constexpr (requires { kind.intensity; })
        kind.intensity *= ratio;
      else
        kind.radiance *= ratio;
    };
    std::visit(scale, light.kind);
  }
}

void PbrtBuilder::ColorSpace(const Token& directive) {
  const std::string name = NeedString("a colour space's name");
  if (name == "srgb") return;
  if (!IsOneOf(name, {"aces2065-1", "rec2020", "dci-p3"})) UnknownType(directive, name, "srgb");
  refusals_.Refuse(directive.where(), "ColorSpace \"" + name + "\" is not supported; use srgb");
}

// Option "type name" value, or "name" value.
void PbrtBuilder::Option(const Token& directive) {
  BeforeWorld(directive);
  std::string name = NeedString("an option's name");
  if (const size_t space = name.find_last_of(' '); space != std::string::npos) name = name.substr(space + 1);
  Token value = Need("the option's value");
  if (value.kind == Token::Kind::kOpen) {
    value = Need("the option's value");
    if (value.kind != Token::Kind::kClose && Need("]").kind != Token::Kind::kClose)
      FailAt(value.where(), ErrorKind::kInvalidInput, "Option \"" + name + "\" takes one value");
  }
  if (value.kind == Token::Kind::kOpen || value.kind == Token::Kind::kClose)
    FailAt(value.where(), ErrorKind::kInvalidInput, "expected the value of Option \"" + name + "\"");
  if (IsOneOf(name, {"disablepixeljitter", "disabletexturefiltering", "forcediffuse"})) {
    if (value.text == "true")
      refusals_.Refuse(directive.where(), "Option \"" + name + "\" is not supported: it changes the image");
    else if (value.text != "false")
      FailAt(value.where(), ErrorKind::kInvalidInput, "Option \"" + name + "\" takes true or false, not " + value.text);
    return;
  }
  // No effect here: no wavelengths, no displacement, seeds from the command line, statistics of pbrt's own.
  if (IsOneOf(name, {"disablewavelengthjitter", "displacementedgescale", "msereferenceimage", "msereferenceout",
                     "rendercoordsys", "seed", "pixelstats", "wavefront"}))
    return;
  FailAt(directive.where(), ErrorKind::kInvalidInput, "pbrt-v4 has no Option \"" + name + "\"");
}

void PbrtBuilder::Accelerator(const Token& directive) {
  BeforeWorld(directive);
  const std::string type = NeedString("an accelerator's name");
  if (!IsOneOf(type, {"bvh", "kdtree"})) UnknownType(directive, type, "bvh, kdtree (without effect)");
  PbrtParams params = Params(directive, type);
  if (type == "bvh")
    params.Accept({"maxnodeprims", "splitmethod"});
  else
    params.Accept({"intersectcost", "traversalcost", "emptybonus", "maxprims", "maxdepth"});
  params.Finish();
}

void PbrtBuilder::MediumInterface(const Token& directive) {
  const std::string inside = NeedString("a medium's name");
  std::string outside = inside;
  if (in_->Peek() && in_->Peek()->kind == Token::Kind::kString) outside = in_->Next()->text;
  // Vacuum on both sides is what everything is in.
  if (!inside.empty() || !outside.empty())
    refusals_.Refuse(directive.where(), "MediumInterface is not supported: there are no participating media");
}

void PbrtBuilder::MakeNamedMedium(const Token& directive) {
  const std::string name = NeedString("a medium's name");
  ReadPbrtParams(*in_);
  refusals_.Refuse(directive.where(),
                   "MakeNamedMedium \"" + name + "\" is not supported: there are no participating media");
}

}  // namespace lodestar
