// Dispatch, blocks, transforms, and files in files.
#include <cmath>

#include "core/scene/pbrt_builder.h"
#include "core/scene/pbrt_file.h"

namespace lodestar {
namespace {

constexpr int kMaxIncludeDepth = 32;
constexpr size_t kMaxBlocks = 10000;

bool IsFinite(const Transform& t) {
  for (const auto& row : t.matrix())
    for (double v : row)
      if (!std::isfinite(v)) return false;
  return true;
}

Vec3 ToVec3(const std::vector<double>& v, size_t at) {
  return {static_cast<float>(v[at]), static_cast<float>(v[at + 1]), static_cast<float>(v[at + 2])};
}

}  // namespace

const std::map<std::string_view, PbrtBuilder::Directive>& PbrtBuilder::Directives() {
  using B = PbrtBuilder;
  static const std::map<std::string_view, Directive> table = {{"Accelerator", &B::Accelerator},
                                                              {"ActiveTransform", &B::ActiveTransform},
                                                              {"AreaLightSource", &B::AreaLightSource},
                                                              {"Attribute", &B::Attribute},
                                                              {"AttributeBegin", &B::AttributeBegin},
                                                              {"AttributeEnd", &B::AttributeEnd},
                                                              {"Camera", &B::Camera},
                                                              {"ColorSpace", &B::ColorSpace},
                                                              {"ConcatTransform", &B::ConcatTransform},
                                                              {"CoordSysTransform", &B::CoordSysTransform},
                                                              {"CoordinateSystem", &B::CoordinateSystem},
                                                              {"Film", &B::Film},
                                                              {"Identity", &B::Identity},
                                                              {"Import", &B::Import},
                                                              {"Include", &B::Include},
                                                              {"Integrator", &B::Integrator},
                                                              {"LightSource", &B::LightSource},
                                                              {"LookAt", &B::LookAt},
                                                              {"MakeNamedMaterial", &B::MakeNamedMaterial},
                                                              {"MakeNamedMedium", &B::MakeNamedMedium},
                                                              {"Material", &B::Material},
                                                              {"MediumInterface", &B::MediumInterface},
                                                              {"NamedMaterial", &B::NamedMaterial},
                                                              {"ObjectBegin", &B::ObjectBegin},
                                                              {"ObjectEnd", &B::ObjectEnd},
                                                              {"ObjectInstance", &B::ObjectInstance},
                                                              {"Option", &B::Option},
                                                              {"PixelFilter", &B::PixelFilter},
                                                              {"ReverseOrientation", &B::ReverseOrientation},
                                                              {"Rotate", &B::Rotate},
                                                              {"Sampler", &B::Sampler},
                                                              {"Scale", &B::Scale},
                                                              {"Shape", &B::Shape},
                                                              {"Texture", &B::Texture},
                                                              {"Transform", &B::SetTransform},
                                                              {"TransformBegin", &B::TransformBegin},
                                                              {"TransformEnd", &B::TransformEnd},
                                                              {"TransformTimes", &B::TransformTimes},
                                                              {"Translate", &B::Translate},
                                                              {"WorldBegin", &B::WorldBegin},
                                                              {"WorldEnd", &B::Version3},
                                                              {"Renderer", &B::Version3},
                                                              {"SurfaceIntegrator", &B::Version3},
                                                              {"VolumeIntegrator", &B::Version3},
                                                              {"Volume", &B::Version3}};
  return table;
}

PbrtBuilder::PbrtBuilder(const ParseOptions& options, std::filesystem::path folder)
    : refusals_(options.lenient), within_(options.within.lexically_normal()), root_(std::move(folder)) {}

void PbrtBuilder::AddFile(const std::filesystem::path& path) {
  std::string name = path.lexically_normal().string();
  if (files_.insert(name).second) scene_.files.push_back(std::move(name));
}

void PbrtBuilder::Read(Tokenizer& in, const std::filesystem::path& folder) {
  Tokenizer* const outer = in_;
  const std::filesystem::path outer_folder = folder_;
  in_ = &in;
  folder_ = folder;
  while (const auto token = in.Next()) {
    if (token->kind != Token::Kind::kWord)
      FailAt(token->where(), ErrorKind::kInvalidInput,
             "expected a directive, but found " +
                 (token->kind == Token::Kind::kString ? '"' + token->text + '"' : token->text));
    const auto directive = Directives().find(token->text);
    if (directive == Directives().end())
      FailAt(token->where(), ErrorKind::kInvalidInput,
             "unknown directive \"" + token->text + "\"; pbrt-v4 has none of that name (names are case-sensitive)");
    (this->*directive->second)(*token);
  }
  in_ = outer;
  folder_ = outer_folder;
}

SceneDescription PbrtBuilder::Finish(const SourceLocation& end) {
  if (!blocks_.empty())
    FailAt(blocks_.back().where, ErrorKind::kInvalidInput, "this " + blocks_.back().begin + " is never ended");
  if (!in_world_) FailAt(end, ErrorKind::kInvalidInput, "the file ends without a WorldBegin");
  CheckMaterials();
  CheckLights();
  Expose();
  scene_.left_out = refusals_.Take();
  return std::move(scene_);
}

// ---- arguments
// ----------------------------------------------------------------------------------------------------------------------------

Token PbrtBuilder::Need(const char* what) {
  auto token = in_->Next();
  if (!token) FailAt(in_->Here(), ErrorKind::kInvalidInput, std::string("the file ends where ") + what + " should be");
  return *std::move(token);
}

std::string PbrtBuilder::NeedString(const char* what) {
  const Token token = Need(what);
  if (token.kind != Token::Kind::kString)
    FailAt(token.where(), ErrorKind::kInvalidInput, std::string("expected ") + what + " in quotes, not " + token.text);
  return token.text;
}

// `count` numbers, with or without brackets.
std::vector<double> PbrtBuilder::Numbers(size_t count, const char* what) {
  std::vector<double> values;
  Token token = Need(what);
  const bool bracketed = token.kind == Token::Kind::kOpen;
  if (bracketed) token = Need(what);
  while (true) {
    values.push_back(PbrtNumber(token, std::string(what) + ": expected"));
    if (values.size() == count) break;
    token = Need(what);
  }
  if (bracketed) {
    token = Need("the closing ]");
    if (token.kind != Token::Kind::kClose)
      FailAt(token.where(), ErrorKind::kInvalidInput,
             std::string(what) + ": expected ] after " + std::to_string(count) + " numbers");
  }
  return values;
}

PbrtParams PbrtBuilder::Params(const Token& directive, const std::string& type, const std::string& target) {
  const std::string label = type.empty() ? directive.text : directive.text + " \"" + type + "\"";
  return PbrtParams(label, directive.where(), ReadPbrtParams(*in_),
                    target.empty() ? std::vector<PbrtParam>() : state_.attributes[target], &refusals_);
}

void PbrtBuilder::BeforeWorld(const Token& directive) {
  if (in_world_) FailAt(directive.where(), ErrorKind::kInvalidInput, directive.text + " must stand before WorldBegin");
}
void PbrtBuilder::InWorld(const Token& directive) {
  if (!in_world_) FailAt(directive.where(), ErrorKind::kInvalidInput, directive.text + " must stand after WorldBegin");
}
void PbrtBuilder::UnknownType(const Token& directive, const std::string& type, const std::string& known) {
  FailAt(directive.where(), ErrorKind::kInvalidInput,
         "pbrt-v4 has no " + directive.text + " \"" + type + "\"; supported here: " + known);
}

// ---- transforms
// ---------------------------------------------------------------------------------------------------------------------------

void PbrtBuilder::Set(const Token& directive, const Transform& transform) {
  if (!IsFinite(transform) || !transform.Invertible())
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           directive.text + " makes the current transformation singular (it flattens space, or is not finite)");
  if (state_.transforms_active) state_.ctm = transform;
}
void PbrtBuilder::Apply(const Token& directive, const Transform& transform) {
  // On its own first: a singular factor would be hidden by the product's separately kept inverse.
  if (!IsFinite(transform) || !transform.Invertible())
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           directive.text + " is singular (it flattens space, or is not finite)");
  Set(directive, state_.ctm * transform);
}

void PbrtBuilder::Identity(const Token& directive) {
  Set(directive, Transform());
}
void PbrtBuilder::Translate(const Token& directive) {
  Apply(directive, Transform::Translate(ToVec3(Numbers(3, "Translate"), 0)));
}
void PbrtBuilder::Scale(const Token& directive) {
  Apply(directive, Transform::Scale(ToVec3(Numbers(3, "Scale"), 0)));
}
void PbrtBuilder::Rotate(const Token& directive) {
  const auto v = Numbers(4, "Rotate");
  const Vec3 axis = ToVec3(v, 1);
  if (!(LengthSquared(axis) > 0))
    FailAt(directive.where(), ErrorKind::kInvalidInput, "Rotate: the axis must not be zero");
  // Whole turns first: sine and cosine are exact enough only for moderate angles.
  Apply(directive, Transform::Rotate(static_cast<float>(std::remainder(v[0], 360.0)), axis));
}
void PbrtBuilder::LookAt(const Token& directive) {
  const auto v = Numbers(9, "LookAt");
  const Vec3 eye = ToVec3(v, 0), target = ToVec3(v, 3), up = ToVec3(v, 6);
  const Vec3 direction = target - eye;
  if (!(LengthSquared(direction) > 0))
    FailAt(directive.where(), ErrorKind::kInvalidInput, "LookAt: the eye and the target are the same point");
  if (!(LengthSquared(up) > 0) || !(Length(Cross(Normalize(up), Normalize(direction))) > 1e-6f))
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "LookAt: the up vector is zero or parallel to the viewing direction");
  Apply(directive, Transform::LookAt(eye, target, up));
}

// Files hold the matrix column by column.
static Transform FromColumns(const std::vector<double>& v) {
  Transform::Matrix m;
  for (size_t i = 0; i < 16; ++i) m[i % 4][i / 4] = v[i];
  return Transform(m);
}
void PbrtBuilder::SetTransform(const Token& directive) {
  Set(directive, FromColumns(Numbers(16, "Transform")));
}
void PbrtBuilder::ConcatTransform(const Token& directive) {
  Apply(directive, FromColumns(Numbers(16, "ConcatTransform")));
}

void PbrtBuilder::CoordinateSystem(const Token&) {
  coordinate_systems_[NeedString("a coordinate system's name")] = state_.ctm;
}
void PbrtBuilder::CoordSysTransform(const Token& directive) {
  const std::string name = NeedString("a coordinate system's name");
  const auto found = coordinate_systems_.find(name);
  if (found == coordinate_systems_.end())
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "no coordinate system \"" + name +
               "\" has been named so far (CoordinateSystem does; \"camera\" and \"world\" exist once they are set)");
  Set(directive, found->second);
}

void PbrtBuilder::TransformTimes(const Token&) {
  Numbers(2, "TransformTimes");
}  // no effect without motion, which ActiveTransform would start
void PbrtBuilder::ActiveTransform(const Token& directive) {
  const Token which = Need("All, StartTime or EndTime");
  if (which.IsWord("StartTime") || which.IsWord("EndTime"))
    refusals_.Refuse(directive.where(), "ActiveTransform " + which.text + " is not supported: there is no motion blur");
  else if (!which.IsWord("All"))
    FailAt(which.where(), ErrorKind::kInvalidInput, "expected All, StartTime or EndTime, not " + which.text);
  state_.transforms_active = !which.IsWord("EndTime");
}

// ---- blocks
// -------------------------------------------------------------------------------------------------------------------------------

void PbrtBuilder::Begin(const Token& directive) {
  if (blocks_.size() >= kMaxBlocks)
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "blocks are nested more than " + std::to_string(kMaxBlocks) + " deep");
  blocks_.push_back({directive.text, state_, directive.where()});
}
void PbrtBuilder::End(const Token& directive, const std::string& begin) {
  if (blocks_.empty()) FailAt(directive.where(), ErrorKind::kInvalidInput, directive.text + " without its " + begin);
  if (blocks_.back().begin != begin)
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           directive.text + " where the open block is the " + blocks_.back().begin + " at " +
               blocks_.back().where.ToString());
  if (begin == "TransformBegin")
    state_.ctm = blocks_.back().saved.ctm;
  else
    state_ = std::move(blocks_.back().saved);
  blocks_.pop_back();
}
void PbrtBuilder::AttributeBegin(const Token& directive) {
  Begin(directive);
}
void PbrtBuilder::AttributeEnd(const Token& directive) {
  End(directive, "AttributeBegin");
}
void PbrtBuilder::TransformBegin(const Token& directive) {
  Begin(directive);
}
void PbrtBuilder::TransformEnd(const Token& directive) {
  End(directive, "TransformBegin");
}

void PbrtBuilder::Attribute(const Token& directive) {
  const std::string target = NeedString("a target (shape, light, material, texture or medium)");
  if (target != "shape" && target != "light" && target != "material" && target != "texture" && target != "medium")
    FailAt(directive.where(), ErrorKind::kInvalidInput,
           "Attribute \"" + target + "\": expected \"shape\", \"light\", \"material\", \"texture\" or \"medium\"");
  std::vector<PbrtParam>& held = state_.attributes[target];
  for (PbrtParam& param : ReadPbrtParams(*in_)) {
    std::erase_if(held, [&](const PbrtParam& p) { return p.name == param.name; });
    held.push_back(std::move(param));
  }
}

void PbrtBuilder::WorldBegin(const Token& directive) {
  if (in_world_) FailAt(directive.where(), ErrorKind::kInvalidInput, "a second WorldBegin");
  in_world_ = true;
  state_.ctm = Transform();
  state_.transforms_active = true;
  coordinate_systems_["world"] = state_.ctm;
}

void PbrtBuilder::ReverseOrientation(const Token& directive) {
  InWorld(directive);
  state_.reverse_orientation = !state_.reverse_orientation;
}

void PbrtBuilder::Version3(const Token& directive) {
  FailAt(directive.where(), ErrorKind::kInvalidInput,
         directive.text + " belongs to an older pbrt; convert the file with pbrt-v4's \"pbrt --upgrade\"");
}

// ---- files in files
// -------------------------------------------------------------------------------------------------------------------------

void PbrtBuilder::IncludeFile(const Token& directive) {
  const std::string name = NeedString("a file name");
  if (depth_ >= kMaxIncludeDepth)
    FailAt(
        directive.where(), ErrorKind::kInvalidInput,
        "files include each other more than " + std::to_string(kMaxIncludeDepth) + " deep; does one include itself?");
  const std::filesystem::path path = Resolve(directive.where(), name);
  std::string text;
  try {
    text = ReadFileMaybeGzip(path);
  } catch (const Error& error) {
    FailAt(directive.where(), error.kind(), directive.text + ": " + error.what());
  }
  AddFile(path);
  Tokenizer in(std::move(text), path.string());
  ++depth_;
  Read(in, path.parent_path());
  --depth_;
}

void PbrtBuilder::Include(const Token& directive) {
  IncludeFile(directive);
}

// An imported file starts from the attributes here and leaves them as they were.
void PbrtBuilder::Import(const Token& directive) {
  InWorld(directive);
  Begin(directive);
  const size_t open = blocks_.size();
  const auto systems = coordinate_systems_;
  IncludeFile(directive);
  if (blocks_.size() != open)
    FailAt(blocks_.back().where, ErrorKind::kInvalidInput,
           "this " + blocks_.back().begin + " of an imported file is never ended in it");
  End(directive, "Import");
  coordinate_systems_ = systems;
}

}  // namespace lodestar
