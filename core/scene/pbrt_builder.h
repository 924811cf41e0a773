// Carries out the directives of a pbrt-v4 file and gathers the SceneDescription. One source file a topic:
// pbrt_directives.cpp (dispatch, blocks, transforms), pbrt_options.cpp (what stands before WorldBegin),
// pbrt_textures.cpp, pbrt_materials.cpp, pbrt_shapes.cpp, pbrt_lights.cpp, pbrt_values.cpp.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/math/spectrum.h"
#include "core/scene/pbrt_params.h"
#include "core/scene/pbrt_parser.h"

namespace lodestar {

class PbrtBuilder {
 public:
  // Relative names resolve against `folder`, the folder of the scene file as in pbrt, then against that of the file
  // that names them.
  PbrtBuilder(const ParseOptions& options, std::filesystem::path folder);

  // Carries out a file's directives; includes recurse.
  void Read(Tokenizer& in, const std::filesystem::path& folder);
  void AddFile(const std::filesystem::path& path);
  // Checks what can only be known at the end, and hands over the scene.
  SceneDescription Finish(const SourceLocation& end);

 private:
  struct State {
    Transform ctm;
    bool reverse_orientation = false;
    int material = -1;  // none named yet
    std::optional<AreaLightDescription> area_light;
    std::map<std::string, std::vector<PbrtParam>> attributes;  // of the Attribute directive, by target
    bool transforms_active = true;                             // false: those of the shutter's end are being left out
  };
  struct Block {
    std::string begin;  // AttributeBegin, TransformBegin, ObjectBegin or Import
    State saved;
    SourceLocation where;
  };
  struct NamedMaterialEntry {
    int index;
    bool defined;
    SourceLocation first_use;
  };
  using Directive = void (PbrtBuilder::*)(const Token&);
  static const std::map<std::string_view, Directive>& Directives();

  // pbrt_directives.cpp
  Token Need(const char* what);
  std::string NeedString(const char* what);
  std::vector<double> Numbers(size_t count, const char* what);
  PbrtParams Params(const Token& directive, const std::string& type, const std::string& target = "");
  void BeforeWorld(const Token& directive);
  void InWorld(const Token& directive);
  void Apply(const Token& directive, const Transform& transform);
  void Set(const Token& directive, const Transform& transform);
  void Begin(const Token& directive);
  void End(const Token& directive, const std::string& begin);
  [[noreturn]] void UnknownType(const Token& directive, const std::string& type, const std::string& known);
  void AttributeBegin(const Token&);
  void AttributeEnd(const Token&);
  void TransformBegin(const Token&);
  void TransformEnd(const Token&);
  void Attribute(const Token&);
  void Identity(const Token&);
  void Translate(const Token&);
  void Scale(const Token&);
  void Rotate(const Token&);
  void LookAt(const Token&);
  void SetTransform(const Token&);
  void ConcatTransform(const Token&);
  void CoordinateSystem(const Token&);
  void CoordSysTransform(const Token&);
  void TransformTimes(const Token&);
  void ActiveTransform(const Token&);
  void WorldBegin(const Token&);
  void ReverseOrientation(const Token&);
  void Include(const Token&);
  void Import(const Token&);
  void IncludeFile(const Token& directive);
  void Version3(const Token&);

  // pbrt_options.cpp
  void Integrator(const Token&);
  void Sampler(const Token&);
  void PixelFilter(const Token&);
  void Film(const Token&);
  void Camera(const Token&);
  void Expose();
  void ColorSpace(const Token&);
  void Option(const Token&);
  void Accelerator(const Token&);
  void MediumInterface(const Token&);
  void MakeNamedMedium(const Token&);

  // pbrt_values.cpp
  std::filesystem::path Resolve(const SourceLocation& where, const std::string& name) const;
  std::string NeedFile(const PbrtParams& params, const PbrtParam& param, const std::string& name);
  SampledSpectrum Samples(const PbrtParams& params, const PbrtParam& param);
  Rgb SurfaceSpectrum(const PbrtParams& params, const PbrtParam& param, bool albedo);
  int TextureIndex(const PbrtParams& params, const PbrtParam& param, bool is_float);
  RgbValue RgbParam(PbrtParams& params, std::string_view name, Rgb otherwise, bool albedo);
  FloatValue FloatParam(PbrtParams& params, std::string_view name, float otherwise);
  Rgb LightSpectrum(PbrtParams& params, std::string_view name);
  float Eta(PbrtParams& params, std::string_view name, float otherwise);

  // pbrt_textures.cpp
  void Texture(const Token&);
  RgbValue TextureOperand(PbrtParams& params, std::string_view name, float otherwise, bool is_float);
  UvMapping Mapping(PbrtParams& params);
  ImageTexture Image(PbrtParams& params);

  // pbrt_materials.cpp
  using MaterialKind = decltype(MaterialDescription::kind);
  void Material(const Token&);
  void NamedMaterial(const Token&);
  void MakeNamedMaterial(const Token&);
  MaterialKind ReadMaterial(const std::string& type, const Token& directive, PbrtParams& params);
  Roughness ReadRoughness(PbrtParams& params, const std::string& prefix, bool remap);
  ConductorMaterial Conductor(PbrtParams& params, const std::string& prefix, const std::string& roughness_prefix,
                              bool remap);
  MixMaterial Mix(PbrtParams& params);
  int NamedMaterialIndex(const std::string& name, const SourceLocation& where);
  void CheckMaterials() const;
  void CheckLights();

  // pbrt_shapes.cpp
  void Shape(const Token&);
  const char* CannotEmit(const ShapeDescription& shape) const;
  void AddShape(ShapeDescription shape);
  std::optional<TriangleMesh> Triangles(PbrtParams& params);
  std::optional<BilinearMesh> Bilinear(PbrtParams& params);
  void ObjectBegin(const Token&);
  void ObjectEnd(const Token&);
  void ObjectInstance(const Token&);

  // pbrt_lights.cpp
  void AreaLightSource(const Token&);
  void LightSource(const Token&);

  SceneDescription scene_;
  PbrtRefusals refusals_;
  std::filesystem::path within_;  // ParseOptions'
  std::filesystem::path root_;
  std::filesystem::path folder_;  // of the file being read
  Tokenizer* in_ = nullptr;
  int depth_ = 0;  // of includes

  float iso_ = 100, exposure_seconds_ = 1;

  State state_;
  std::vector<Block> blocks_;
  bool in_world_ = false;
  std::map<std::string, Transform> coordinate_systems_;
  std::map<std::string, int> float_textures_, spectrum_textures_;
  std::map<std::string, NamedMaterialEntry> named_materials_;
  int default_material_ = -1;
  std::map<std::string, int> objects_;
  int current_object_ = -1;  // between ObjectBegin and ObjectEnd
  std::set<std::string> files_;
};

}  // namespace lodestar
