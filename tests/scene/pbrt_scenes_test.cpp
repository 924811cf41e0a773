// Whole scenes: the shared ones (where they are), and what a damaged file does.
#include "core/scene/ply.h"
#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

struct SharedScene {
  const char* file;
  size_t shapes, materials, textures, lights, area_lights, triangles;
  int width, height, depth;
};

void PrintTo(const SharedScene& scene, std::ostream* out) {
  *out << scene.file;
}

class SharedScenes : public testing::TestWithParam<SharedScene> {};

TEST_P(SharedScenes, Parse) {
  const SharedScene& expected = GetParam();
  const std::filesystem::path path = std::filesystem::path(LODESTAR_SOURCE_DIR) / "../shared/scenes" / expected.file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const SceneDescription scene = ParsePbrtFile(path);
  EXPECT_EQ(scene.shapes.size(), expected.shapes);
  EXPECT_EQ(scene.materials.size(), expected.materials);
  EXPECT_EQ(scene.textures.size(), expected.textures);
  EXPECT_EQ(scene.lights.size(), expected.lights);
  EXPECT_EQ(scene.resolution_x, expected.width);
  EXPECT_EQ(scene.resolution_y, expected.height);
  EXPECT_EQ(scene.max_depth, expected.depth);
  EXPECT_TRUE(scene.left_out.empty());
  size_t area_lights = 0, triangles = 0;
  for (const ShapeDescription& shape : scene.shapes) {
    area_lights += shape.light.has_value();
    if (const auto* mesh = std::get_if<TriangleMesh>(&shape.kind)) triangles += mesh->triangles.size();
    if (const auto* ply = std::get_if<PlyMesh>(&shape.kind)) triangles += ReadPly(ply->path).triangles.size();
    EXPECT_LT(static_cast<size_t>(shape.material), scene.materials.size());
  }
  EXPECT_EQ(area_lights, expected.area_lights);
  EXPECT_EQ(triangles, expected.triangles);
  for (const std::string& file : scene.files) EXPECT_TRUE(std::filesystem::exists(file)) << file;
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedScenes,
    testing::Values(SharedScene{"veach-ajar/veach-ajar.pbrt", 22, 13, 3, 0, 1, 382690, 1280, 720, 20},
                    SharedScene{"living-room/living-room.pbrt", 65, 19, 5, 1, 0, 143163, 1280, 720, 65},
                    SharedScene{"staircase2/staircase2.pbrt", 32, 21, 3, 0, 13, 30927, 1024, 1024, 65},
                    SharedScene{"veach-mis/veach-mis.pbrt", 10, 10, 0, 0, 5, 12, 1152, 864, 5},
                    SharedScene{"veach-mis/veach-mis-colorized.pbrt", 10, 10, 0, 0, 5, 12, 1152, 864, 5}));

// Something of everything, so that its prefixes end in every state of the parser.
const char* const kEverything = R"(# a small scene
Integrator "path" "integer maxdepth" 7
Sampler "zsobol" "integer pixelsamples" [ 4 ]
PixelFilter "mitchell" "float B" .3
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "x\t.exr"
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Attribute "shape" "float alpha" 0.5
Texture "t" "spectrum" "checkerboard" "rgb tex1" [ .1 .2 .3 ] "float uscale" 4
Texture "i" "spectrum" "imagemap" "string filename" "image.png"
MakeNamedMaterial "m" "string type" "coateddiffuse" "texture reflectance" "t"
MakeNamedMaterial "n" "string type" "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
ObjectBegin "o"
  NamedMaterial "m"
  Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 ] "integer indices" [ 0 1 2 ]
ObjectEnd
AttributeBegin
  AreaLightSource "diffuse" "blackbody L" 3000 "bool twosided" true
  Translate 0 2 0 Rotate 30 1 0 0
  Shape "disk" "float radius" .5 "float alpha" 1
AttributeEnd
Material "mix" "string materials" [ "m" "n" ]
Shape "plymesh" "string filename" "mesh.ply"
TransformBegin Scale 1 2 3 ObjectInstance "o" TransformEnd
LightSource "infinite" "spectrum L" [ 400 1 700 2 ]
)";

TEST(PbrtScenes, EveryPrefixParsesOrIsAnErrorWithItsPlace) {
  const std::string text = kEverything;
  const SceneDescription whole = Parse(text);
  EXPECT_EQ(whole.shapes.size(), 2u);
  EXPECT_EQ(whole.instances.size(), 1u);
  size_t parsed = 0;
  for (size_t size = 0; size < text.size(); ++size) {
    try {
      Parse(text.substr(0, size));
      ++parsed;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).rfind("s.pbrt:", 0), 0u) << error.what();
    }
  }
  EXPECT_GT(parsed, 30u);  // the ends of comments and of whole directives
}

TEST(PbrtScenes, EveryDamagedByteParsesOrIsAnError) {
  const std::string text = kEverything;
  uint32_t random = 1;
  for (size_t at = 0; at < text.size(); ++at) {
    std::string damaged = text;
    random = random * 1664525u + 1013904223u;
    constexpr char kBytes[] = "\"[]#\\ \n0-x\xff\0";
    damaged[at] = kBytes[(random >> 16) % (sizeof(kBytes) - 1)];
    for (bool lenient : {false, true}) {
      try {
        Parse(damaged, lenient);
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("s.pbrt:", 0), 0u) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace lodestar
