// Parameters that are more than a number: files, spectra, textures by name.
#include <charconv>
#include <cmath>

#include "core/math/spectrum.h"
#include "core/scene/pbrt_builder.h"
#include "core/scene/pbrt_file.h"

namespace lodestar {
namespace {

std::string Names() {
  std::string out;
  for (std::string_view name : NamedSpectra()) out += (out.empty() ? "" : ", ") + std::string(name);
  return out;
}

// "rgb name" with three non-negative numbers.
Rgb PlainRgb(const PbrtParams& params, const PbrtParam& param) {
  if (param.numbers.size() != 3) params.Fail(param, "takes three numbers, not " + std::to_string(param.numbers.size()));
  for (double v : param.numbers)
    if (v < 0) params.Fail(param, "must not be negative");
  return {static_cast<float>(param.numbers[0]), static_cast<float>(param.numbers[1]),
          static_cast<float>(param.numbers[2])};
}

// A .spd file: wavelength and value in turn, # comments.
std::vector<double> ReadNumbersFile(const std::string& path) {
  Tokenizer in(ReadFileMaybeGzip(path), path);
  std::vector<double> numbers;
  while (const auto token = in.Next()) numbers.push_back(PbrtNumber(*token, "a spectrum file holds"));
  return numbers;
}

}  // namespace

// As pbrt has it, names are relative to the scene file's folder, wherever they stand; names relative to an included
// file are found as well.
std::filesystem::path PbrtBuilder::Resolve(const SourceLocation& where, const std::string& name) const {
  const std::filesystem::path path(name);
  if (path.is_absolute()) {
    if (within_.empty()) return path;
    FailAt(where, ErrorKind::kInvalidInput,
           "\"" + name +
               "\" is an absolute name, and a farm's workers have other folders; name it relative to the scene file's");
  }
  const std::filesystem::path from_root = (root_ / path).lexically_normal(),
                              from_here = (folder_ / path).lexically_normal();
  std::error_code code;
  const std::filesystem::path& found =
      !std::filesystem::exists(from_root, code) && std::filesystem::exists(from_here, code) ? from_here : from_root;
  if (!within_.empty()) {
    const auto inside = std::filesystem::absolute(found).lexically_normal().lexically_relative(within_);
    if (inside.empty() || *inside.begin() == "..")
      FailAt(where, ErrorKind::kInvalidInput, "\"" + name + "\" is outside of the scene's own files");
  }
  return found;
}

std::string PbrtBuilder::NeedFile(const PbrtParams& params, const PbrtParam& param, const std::string& name) {
  if (name.empty()) params.Fail(param, "is empty; expected a file name");
  const std::filesystem::path path = Resolve(param.where, name);
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code))
    FailAt(param.where, ErrorKind::kNotFound,
           params.label() + ": there is no file \"" + path.string() +
               "\" (names are relative to the scene file's folder)");
  AddFile(path);
  return path.string();
}

SampledSpectrum PbrtBuilder::Samples(const PbrtParams& params, const PbrtParam& param) {
  std::vector<double> numbers = param.numbers;
  if (!param.strings.empty()) {
    const std::string& name = param.strings[0];
    if (param.strings.size() != 1 || !numbers.empty())
      params.Fail(param, "takes one name, one file, or pairs of numbers");
    std::error_code code;
    if (!std::filesystem::is_regular_file(Resolve(param.where, name), code))
      FailAt(param.where, ErrorKind::kNotFound,
             "\"" + name + "\" of " + params.label() +
                 " is neither a spectrum file nor a named spectrum of this kind; the names are: " + Names());
    numbers = ReadNumbersFile(NeedFile(params, param, name));
  }
  if (numbers.empty() || numbers.size() % 2 != 0)
    params.Fail(param,
                "takes pairs of wavelength (nm) and value; there are " + std::to_string(numbers.size()) + " numbers");
  SampledSpectrum spectrum;
  for (size_t i = 0; i < numbers.size(); i += 2) {
    if (!spectrum.wavelengths.empty() && !(numbers[i] > spectrum.wavelengths.back()))
      params.Fail(param, "must have its wavelengths in ascending order");
    if (numbers[i + 1] < 0) params.Fail(param, "must not be negative");
    spectrum.wavelengths.push_back(numbers[i]);
    spectrum.values.push_back(numbers[i + 1]);
  }
  return spectrum;
}

Rgb PbrtBuilder::SurfaceSpectrum(const PbrtParams& params, const PbrtParam& param, bool albedo) {
  Rgb value;
  if (param.type == "rgb") {
    value = PlainRgb(params, param);
  } else if (const auto named = param.strings.size() == 1 ? NamedSurfaceSpectrum(param.strings[0]) : std::nullopt) {
    value = *named;
  } else if (const auto glass = param.strings.size() == 1 ? NamedGlassEta(param.strings[0]) : std::nullopt) {
    value = Rgb(static_cast<float>(*glass));
  } else {
    const SampledSpectrum samples = Samples(params, param);
    for (double v : samples.values)
      if (albedo && v > 1) params.Fail(param, "is a reflectance and must not exceed 1");
    value = SurfaceSpectrumToRgb(samples);
    if (albedo) value = Clamp(value, 0, 1);  // narrow bands can leave the gamut upwards
  }
  if (albedo && MaxComponent(value) > 1) params.Fail(param, "is a reflectance and must not exceed 1");
  return value;
}

int PbrtBuilder::TextureIndex(const PbrtParams& params, const PbrtParam& param, bool is_float) {
  if (param.strings.size() != 1) params.Fail(param, "takes one texture name");
  const auto& textures = is_float ? float_textures_ : spectrum_textures_;
  const auto& others = is_float ? spectrum_textures_ : float_textures_;
  const auto found = textures.find(param.strings[0]);
  if (found != textures.end()) return found->second;
  const std::string kind = is_float ? "float" : "spectrum";
  if (others.contains(param.strings[0]))
    params.Fail(param, "needs a " + kind + " texture; \"" + param.strings[0] + "\" is a " +
                           (is_float ? "spectrum" : "float") + " texture");
  params.Fail(param,
              "names \"" + param.strings[0] + "\", but no " + kind + " texture of that name has been defined so far");
}

RgbValue PbrtBuilder::RgbParam(PbrtParams& params, std::string_view name, Rgb otherwise, bool albedo) {
  const PbrtParam* param = params.Find(name, {"rgb", "spectrum", "texture"});
  if (!param) return {otherwise, -1};
  if (param->type == "texture") return {otherwise, TextureIndex(params, *param, false)};
  return {SurfaceSpectrum(params, *param, albedo), -1};
}

FloatValue PbrtBuilder::FloatParam(PbrtParams& params, std::string_view name, float otherwise) {
  const PbrtParam* param = params.Find(name, {"float", "texture"});
  if (param && param->type == "texture") return {otherwise, TextureIndex(params, *param, true)};
  return {params.Float(name, otherwise), -1};
}

Rgb PbrtBuilder::LightSpectrum(PbrtParams& params, std::string_view name) {
  const PbrtParam* param = params.Find(name, {"rgb", "spectrum", "blackbody"});
  if (!param) return Rgb(1);
  if (param->type == "rgb") return PlainRgb(params, *param);
  if (param->type == "blackbody") {
    if (param->numbers.size() != 1) params.Fail(*param, "takes one temperature in kelvin");
    if (!(param->numbers[0] > 0)) params.Fail(*param, "must be greater than 0 (kelvin)");
    return BlackbodyToUnitRgb(param->numbers[0]);
  }
  if (const auto named = param->strings.size() == 1 ? NamedIlluminant(param->strings[0]) : std::nullopt) return *named;
  return EmissionToUnitRgb(Samples(params, *param));
}

float PbrtBuilder::Eta(PbrtParams& params, std::string_view name, float otherwise) {
  const PbrtParam* param = params.Find(name, {"float", "spectrum"});
  if (!param) return otherwise;
  if (param->type == "float") return params.PositiveFloat(name, otherwise);
  double eta = 0;
  if (const auto glass = param->strings.size() == 1 ? NamedGlassEta(param->strings[0]) : std::nullopt)
    eta = *glass;
  else
    eta = Samples(params, *param).At(587.5618);
  if (!(eta > 0)) params.Fail(*param, "has no index of refraction at 587.6 nm");
  return static_cast<float>(eta);
}

}  // namespace lodestar
