// A scene as the file said it: every directive resolved into plain values, nothing compiled. Produced by the parser
// (pbrt_parser.h), consumed by the compiler (scene.h). Spectra are linear RGB already; transforms are
// world-from-object; file names are as written, resolved against the folder of the file that named them. Indices refer
// to the vectors of SceneDescription.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/math/rgb.h"
#include "core/math/transform.h"

namespace lodestar {

// Where a directive stands; printed as file:line:column.
struct SourceLocation {
  std::string file;
  int line = 0, column = 0;
  std::string ToString() const;
};

// ---- textures ----

// A value that is constant or comes from a texture; `texture` indexes SceneDescription::textures, and wins where set.
struct RgbValue {
  Rgb value;
  int texture = -1;
};
struct FloatValue {
  float value = 0;
  int texture = -1;
};

// (u, v) -> (su * u + du, sv * v + dv), pbrt's "uv" mapping.
struct UvMapping {
  float su = 1, sv = 1, du = 0, dv = 0;
};

struct ConstantTexture {
  Rgb value;
};
struct ImageTexture {
  std::string path;
  enum class Wrap { kRepeat, kClamp, kBlack } wrap = Wrap::kRepeat;
  enum class Filter { kPoint, kBilinear, kTrilinear, kEwa } filter = Filter::kBilinear;
  enum class Encoding {
    kSrgb,
    kLinear,
    kGamma
  } encoding = Encoding::kSrgb;  // of 8-bit files; float files are always linear
  float gamma = 1;
  float scale = 1;
  bool invert = false;
  UvMapping mapping;
};
struct ScaleTexture {
  RgbValue tex, scale;
};
struct MixTexture {
  RgbValue a, b;
  RgbValue amount;
};
struct CheckerboardTexture {
  RgbValue a, b;
  UvMapping mapping;
};
struct TextureDescription {
  std::string name;
  bool is_float = false;  // a float texture: its value is the red channel (imagemap: the mean of RGB, or the alpha
                          // where an alpha texture asks)
  std::variant<ConstantTexture, ImageTexture, ScaleTexture, MixTexture, CheckerboardTexture> kind;
  SourceLocation where;
};

// ---- materials ----

// Roughness as a GGX alpha after remapping has been applied for constants; `remap` remains for textured roughness
// (alpha = sqrt(roughness)).
struct Roughness {
  FloatValue u, v;
  bool remap = true;
};
struct DiffuseMaterial {
  RgbValue reflectance{Rgb(0.5f)};
};
struct ConductorMaterial {
  // Either eta and k, or (has_reflectance) the normal-incidence reflectance from which k is derived with eta = 1, as
  // pbrt does.
  RgbValue eta, k;
  bool has_reflectance = false;
  RgbValue reflectance;
  Roughness roughness;
};
struct DielectricMaterial {
  float eta = 1.5f;
  Roughness roughness;
};
struct ThinDielectricMaterial {
  float eta = 1.5f;
};
struct CoatedDiffuseMaterial {
  RgbValue reflectance{Rgb(0.5f)};
  float eta = 1.5f;
  Roughness roughness;
};
struct CoatedConductorMaterial {
  float interface_eta = 1.5f;
  Roughness interface_roughness;
  ConductorMaterial conductor;
};
struct DiffuseTransmissionMaterial {
  RgbValue reflectance{Rgb(0.25f)}, transmittance{Rgb(0.25f)};
  float scale = 1;
};
struct MixMaterial {
  int a = -1, b = -1;  // material indices; the amount is the probability of b
  FloatValue amount{0.5f};
};
struct InterfaceMaterial {};  // no surface at all: rays go straight on
struct MaterialDescription {
  std::string name;  // empty for an unnamed one
  std::variant<DiffuseMaterial, ConductorMaterial, DielectricMaterial, ThinDielectricMaterial, CoatedDiffuseMaterial,
               CoatedConductorMaterial, DiffuseTransmissionMaterial, MixMaterial, InterfaceMaterial>
      kind;
  SourceLocation where;
};

// ---- shapes ----

struct TriangleMesh {
  std::vector<Vec3> positions;  // object space
  std::vector<Vec3> normals;    // empty or one a vertex
  std::vector<Vec2> uvs;        // empty or one a vertex
  std::vector<std::array<uint32_t, 3>> triangles;
};
struct PlyMesh {
  std::string path;  // .ply or .ply.gz, loaded by the compiler through ReadPly
};
struct SphereShape {
  float radius = 1;  // full spheres only
};
struct DiskShape {
  float radius = 1, inner_radius = 0, height = 0;  // in the plane z = height, normal +z
};
struct BilinearMesh {
  std::vector<Vec3> positions;
  std::vector<Vec2> uvs;
  std::vector<Vec3> normals;
  std::vector<std::array<uint32_t, 4>> patches;  // p00, p10, p01, p11
};
struct AreaLightDescription {
  Rgb radiance;  // scale and exposure applied
  bool two_sided = false;
  // > 0: watts (luminous, Y) that the whole light would emit were its radiance of luminance 1; the radiance multiplies
  // it
  float power = 0;
  SourceLocation where;
};
struct ShapeDescription {
  std::variant<TriangleMesh, PlyMesh, SphereShape, DiskShape, BilinearMesh> kind;
  Transform world_from_object;  // object-from-instance for shapes inside an object definition
  bool reverse_orientation = false;
  int material = -1;    // index; never -1 after parsing
  FloatValue alpha{1};  // opacity: a constant, or a float texture
  std::optional<AreaLightDescription> light;
  SourceLocation where;
};
struct ObjectDescription {
  std::string name;
  std::vector<ShapeDescription> shapes;
};
struct InstanceDescription {
  int object = -1;
  Transform world_from_instance;
  SourceLocation where;
};

// ---- lights, camera, film ----

struct PointLight {
  Rgb intensity;  // W/sr; scale, power and exposure applied
  Vec3 from;
};
struct SpotLight {
  Rgb intensity;
  Vec3 from, to;
  float cone_angle = 30, cone_delta = 5;  // degrees; full intensity inside angle - delta
};
struct DistantLight {
  Rgb radiance;   // irradiance on a surface that faces it, W/m^2
  Vec3 to_light;  // world, unit
};
struct InfiniteLight {
  Rgb radiance{Rgb(1)};  // times the image where there is one
  std::string path;      // equal-area octahedral image, or empty
  // Of an image: what arrives on a plane that faces the light's +z (luminance, cosine included); 0: the image as it is.
  float illuminance = 0;
};
struct LightDescription {
  std::variant<PointLight, SpotLight, DistantLight, InfiniteLight> kind;
  Transform world_from_light;  // already applied to positions and directions; needed for the environment map
  SourceLocation where;
};

struct PixelFilterDescription {
  enum class Kind { kBox, kTriangle, kGaussian, kMitchell } kind = Kind::kGaussian;
  float radius_x = 1.5f, radius_y = 1.5f;
  float sigma = 0.5f;                // gaussian
  float b = 1 / 3.0f, c = 1 / 3.0f;  // mitchell
  // box | triangle | gaussian | mitchell with pbrt-v4's default radii; throws Error(kInvalidInput) for another name.
  static PixelFilterDescription Named(const std::string& name);
};

struct CameraDescription {
  Transform camera_from_world;
  float fov = 90;                                  // degrees, of the shorter image axis
  std::array<float, 4> screen_window{0, 0, 0, 0};  // x0 x1 y0 y1; all zero: derived from the aspect ratio
  float lens_radius = 0, focal_distance = 1e6f;
};

struct SceneDescription {
  CameraDescription camera;
  int resolution_x = 1280, resolution_y = 720;
  PixelFilterDescription filter;
  int max_depth = 5;  // of the file's Integrator directive
  int samples_per_pixel = 16;
  std::vector<TextureDescription> textures;
  std::vector<MaterialDescription> materials;
  std::vector<ShapeDescription> shapes;
  std::vector<ObjectDescription> objects;
  std::vector<InstanceDescription> instances;
  std::vector<LightDescription> lights;
  std::vector<std::string>
      files;  // every file the scene needs: the scene file first, then includes, meshes, images (for upload)
  std::vector<std::string> left_out;  // --lenient: "file:line:column: what"
};

}  // namespace lodestar
