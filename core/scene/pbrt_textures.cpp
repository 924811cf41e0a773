#include <algorithm>

#include "core/scene/pbrt_builder.h"

namespace lodestar {
namespace {

template <class Value>
using Choices = std::initializer_list<std::pair<std::string_view, Value>>;

// The value that a string parameter names, among the choices.
template <class Value>
Value Choose(PbrtParams& params, std::string_view name, Value otherwise, Choices<Value> choices) {
  const PbrtParam* param = params.Find(name, {"string"});
  if (!param) return otherwise;
  const std::string text = params.String(name, "");
  std::string known;
  for (const auto& [choice, value] : choices) {
    if (text == choice) return value;
    known += (known.empty() ? "" : ", ") + std::string(choice);
  }
  params.Fail(*param, "is \"" + text + "\"; expected one of: " + known);
}

bool IsUnsupportedTexture(std::string_view type) {
  for (std::string_view name : {"bilerp", "directionmix", "dots", "fbm", "marble", "ptex", "windy", "wrinkled"})
    if (type == name) return true;
  return false;
}

}  // namespace

UvMapping PbrtBuilder::Mapping(PbrtParams& params) {
  UvMapping mapping;
  const std::string kind = params.String("mapping", "uv");
  if (kind == "spherical" || kind == "cylindrical" || kind == "planar") {
    params.Refuse({"mapping"}, "only \"uv\" is");
    params.Accept({"v1", "v2"});
  } else if (kind != "uv") {
    params.Fail(*params.Find("mapping", {"string"}), "is \"" + kind + "\"; expected \"uv\"");
  }
  mapping.su = params.Float("uscale", 1);
  mapping.sv = params.Float("vscale", 1);
  mapping.du = params.Float("udelta", 0);
  mapping.dv = params.Float("vdelta", 0);
  return mapping;
}

ImageTexture PbrtBuilder::Image(PbrtParams& params) {
  ImageTexture image;
  const PbrtParam* file = params.Find("filename", {"string"});
  if (!file) FailAt(params.where(), ErrorKind::kInvalidInput, params.label() + " needs a \"string filename\"");
  image.path = NeedFile(params, *file, params.String("filename", ""));
  using Wrap = ImageTexture::Wrap;
  using Filter = ImageTexture::Filter;
  if (params.String("wrap", "") == "octahedralsphere")
    params.Refuse({"wrap"}, "use repeat, clamp or black");
  else
    image.wrap = Choose<Wrap>(params, "wrap", Wrap::kRepeat,
                              {{"repeat", Wrap::kRepeat}, {"clamp", Wrap::kClamp}, {"black", Wrap::kBlack}});
  image.filter = Choose<Filter>(params, "filter", Filter::kBilinear,
                                {{"point", Filter::kPoint},
                                 {"bilinear", Filter::kBilinear},
                                 {"trilinear", Filter::kTrilinear},
                                 {"ewa", Filter::kEwa},
                                 {"EWA", Filter::kEwa}});
  params.Accept({"maxanisotropy"});  // how far ewa may blur, not what it shows
  image.scale = params.Float("scale", 1);
  image.invert = params.Bool("invert", false);
  const std::string encoding = params.String("encoding", "sRGB");
  if (encoding == "linear") {
    image.encoding = ImageTexture::Encoding::kLinear;
  } else if (encoding.starts_with("gamma ")) {
    image.encoding = ImageTexture::Encoding::kGamma;
    const PbrtParam& param = *params.Find("encoding", {"string"});
    Token number;
    number.text = encoding.substr(6);
    number.file = std::make_shared<const std::string>(param.where.file);
    number.line = param.where.line;
    number.column = param.where.column;
    image.gamma = static_cast<float>(PbrtNumber(number, "\"string encoding\": gamma takes"));
    if (!(image.gamma > 0)) params.Fail(param, "needs a gamma greater than 0");
  } else if (encoding != "sRGB") {
    params.Fail(*params.Find("encoding", {"string"}), "is \"" + encoding + "\"; expected sRGB, linear or gamma X");
  }
  image.mapping = Mapping(params);
  return image;
}

// An operand of scale, mix or checkerboard: of the texture's own kind.
RgbValue PbrtBuilder::TextureOperand(PbrtParams& params, std::string_view name, float otherwise, bool is_float) {
  if (!is_float) return RgbParam(params, name, Rgb(otherwise), false);
  const FloatValue value = FloatParam(params, name, otherwise);
  return {Rgb(value.value), value.texture};
}

void PbrtBuilder::Texture(const Token& directive) {
  InWorld(directive);
  TextureDescription texture;
  texture.name = NeedString("a texture's name");
  texture.where = directive.where();
  const Token kind = Need("float or spectrum");
  if (kind.kind != Token::Kind::kString || (kind.text != "float" && kind.text != "spectrum"))
    FailAt(kind.where(), ErrorKind::kInvalidInput,
           "Texture \"" + texture.name + "\": expected \"float\" or \"spectrum\", not \"" + kind.text + "\"");
  texture.is_float = kind.text == "float";
  const std::string type = NeedString("a texture's type");
  PbrtParams params = Params(directive, type, "texture");
  auto& names = texture.is_float ? float_textures_ : spectrum_textures_;
  if (names.contains(texture.name))
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "a " + kind.text + " texture \"" + texture.name + "\" is defined already, at " +
               scene_.textures[names[texture.name]].where.ToString());

  if (type == "constant") {
    texture.kind = ConstantTexture{TextureOperand(params, "value", 1, texture.is_float).value};
    if (const PbrtParam* value = params.Find("value", {"float", "rgb", "spectrum", "texture"});
        value && value->type == "texture")
      params.Fail(*value, "must be a constant");
  } else if (type == "imagemap") {
    texture.kind = Image(params);
  } else if (type == "scale") {
    ScaleTexture scale;
    scale.tex = TextureOperand(params, "tex", 1, texture.is_float);
    scale.scale = TextureOperand(params, "scale", 1, true);  // a float, also where the texture is not
    texture.kind = scale;
  } else if (type == "mix") {
    texture.kind =
        MixTexture{TextureOperand(params, "tex1", 0, texture.is_float),
                   TextureOperand(params, "tex2", 1, texture.is_float), TextureOperand(params, "amount", 0.5f, true)};
  } else if (type == "checkerboard") {
    const int dimension = params.Int("dimension", 2);
    if (dimension == 3)
      params.Refuse({"dimension"}, "only 2 is");
    else if (dimension != 2)
      params.Fail(*params.Find("dimension", {"integer"}), "must be 2");
    texture.kind = CheckerboardTexture{TextureOperand(params, "tex1", 1, texture.is_float),
                                       TextureOperand(params, "tex2", 0, texture.is_float), Mapping(params)};
  } else if (IsUnsupportedTexture(type)) {
    refusals_.Refuse(directive.where(),
                     params.label() + " is not supported; use constant, imagemap, scale, mix or checkerboard");
    texture.kind = ConstantTexture{Rgb(0.5f)};  // lenient: a stand-in, so that what refers to it still does
    names[texture.name] = static_cast<int>(scene_.textures.size());
    scene_.textures.push_back(std::move(texture));
    return;
  } else {
    UnknownType(directive, type, "constant, imagemap, scale, mix, checkerboard");
  }
  params.Finish();
  names[texture.name] = static_cast<int>(scene_.textures.size());
  scene_.textures.push_back(std::move(texture));
}

}  // namespace lodestar
