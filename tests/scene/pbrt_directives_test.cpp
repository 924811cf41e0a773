// Words, blocks, transforms, included files.
#include <zlib.h>

#include "core/scene/pbrt_tokenizer.h"
#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

TEST(PbrtTokenizer, SplitsWordsStringsAndBrackets) {
  Tokenizer in("Shape # comment \"[\n  \"a \\\"b\\\" \\\\ \\t\"[1 -2.5]x\n", "f");
  const std::vector<std::tuple<Token::Kind, std::string, int, int>> expected = {
      {Token::Kind::kWord, "Shape", 1, 1}, {Token::Kind::kString, "a \"b\" \\ \t", 2, 3},
      {Token::Kind::kOpen, "[", 2, 18},    {Token::Kind::kWord, "1", 2, 19},
      {Token::Kind::kWord, "-2.5", 2, 21}, {Token::Kind::kClose, "]", 2, 25},
      {Token::Kind::kWord, "x", 2, 26}};
  for (const auto& [kind, text, line, column] : expected) {
    const auto peeked = in.Peek();
    const auto token = in.Next();
    ASSERT_TRUE(token && peeked);
    EXPECT_EQ(peeked->text, token->text);
    EXPECT_EQ(token->kind, kind) << text;
    EXPECT_EQ(token->text, text);
    EXPECT_EQ(token->where().ToString(), "f:" + std::to_string(line) + ":" + std::to_string(column));
  }
  EXPECT_FALSE(in.Next());
  EXPECT_EQ(in.Here().ToString(), "f:3:1");
}

TEST(PbrtDirectives, RefusesMalformedText) {
  const Refused cases[] = {
      {"", kBad, "1:1", "without a WorldBegin"},
      {"Identity", kBad, "1:9", "without a WorldBegin"},
      {"Sphere 1", kBad, "1:1", "unknown directive \"Sphere\""},
      {"worldbegin", kBad, "1:1", "case-sensitive"},
      {"\"Shape\"", kBad, "1:1", "expected a directive"},
      {"]", kBad, "1:1", "expected a directive"},
      {"WorldBegin WorldBegin", kBad, "1:12", "a second WorldBegin"},
      {"WorldBegin WorldEnd", kBad, "1:12", "--upgrade"},
      {"Renderer \"sampler\"", kBad, "1:1", "--upgrade"},
      {"SurfaceIntegrator \"path\"", kBad, "1:1", "--upgrade"},
      {"VolumeIntegrator \"single\"", kBad, "1:1", "--upgrade"},
      {"Volume \"homogeneous\"", kBad, "1:1", "--upgrade"},
      {"Film \"rgb", kBad, "1:6", "no closing quote"},
      {"Film \"rgb\n\"", kBad, "1:6", "no closing quote"},
      {"Film \"rgb\\", kBad, "1:6", "no closing quote"},
      {"Film \"r\\qb\"", kBad, "1:8", "unknown escape"},
      {"Film", kBad, "1:5", "the file ends where a film's name"},
      {"Film rgb", kBad, "1:6", "in quotes"},
      {"Film \"rgb\" \"xresolution\" 4", kBad, "1:12", "\"type name\""},
      {"Film \"rgb\" \"int xresolution\" 4", kBad, "1:12", "unknown parameter type \"int\""},
      {"Film \"rgb\" \"integer xresolution\"", kBad, "1:33", "the file ends where the value"},
      {"Film \"rgb\" \"integer xresolution\" ]", kBad, "1:34", "not ]"},
      {"Film \"rgb\" \"integer xresolution\" [4", kBad, "1:34", "never closed"},
      {"Film \"rgb\" \"integer xresolution\" [[4]]", kBad, "1:35", "a [ inside"},
      {"Film \"rgb\" \"integer xresolution\" [4 4]", kBad, "1:12", "takes one value, not 2"},
      {"Film \"rgb\" \"integer xresolution\" []", kBad, "1:12", "takes one value, not 0"},
      {"Film \"rgb\" \"integer xresolution\" 4.5", kBad, "1:34", "integers, not 4.5"},
      {"Film \"rgb\" \"integer xresolution\" 4e12", kBad, "1:34", "32-bit"},
      {"Film \"rgb\" \"integer xresolution\" four", kBad, "1:34", "a number, not \"four\""},
      {"Film \"rgb\" \"integer xresolution\" 0x10", kBad, "1:34", "a number"},
      {"Film \"rgb\" \"integer xresolution\" \"4\"", kBad, "1:34", "a number"},
      {"Film \"rgb\" \"float xresolution\" 4", kBad, "1:12", "expected \"integer xresolution\""},
      {"Film \"rgb\" \"integer xresolution\" 4 \"integer xresolution\" 5", kBad, "1:36",
       "given twice; first at s.pbrt:1:12"},
      {"Film \"rgb\" \"string filename\" 4", kBad, "1:30", "a quoted string"},
      {"Film \"rgb\" \"bool savefp16\" \"true\"", kBad, "1:28", "true or false (without quotes)"},
      {"Film \"rgb\" \"bool savefp16\" 1", kBad, "1:28", "true or false"},
      {"Camera \"perspective\" \"float fov\" nan", kBad, "1:34", "a finite number"},
      {"Camera \"perspective\" \"float fov\" -inf", kBad, "1:34", "a finite number"},
      {"Camera \"perspective\" \"float fov\" 1e39", kBad, "1:34", "a finite number"},
      {"Camera \"perspective\" \"float fov\" 1e999", kBad, "1:34", "a finite number"},
      {"Camera \"perspective\" \"rgb fov\" [1 1 1]", kBad, "1:22", "expected \"float fov\""},
      {"Camera \"perspective\" \"float foo\" 1", kBad, "1:22", "is not used; it takes: "},
  };
  for (const Refused& c : cases) ExpectRefused(c, false);
}

TEST(PbrtDirectives, NumbersMayBeTinyOrSigned) {
  EXPECT_EQ(Parse("Camera \"perspective\" \"float lensradius\" 1e-400 WorldBegin").camera.lens_radius, 0);
  EXPECT_EQ(Parse("Camera \"perspective\" \"float fov\" +45 WorldBegin").camera.fov, 45);
  EXPECT_EQ(Parse("Camera \"perspective\" \" float  fov \" [.5e2] WorldBegin").camera.fov, 50);
}

// ---- transforms
// ---------------------------------------------------------------------------------------------------------------------------

Vec3 Place(const std::string& text, Vec3 p) {
  return ParseWorld(text + " Shape \"sphere\"").shapes.at(0).world_from_object.Point(p);
}
void ExpectVec(Vec3 actual, Vec3 expected) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], 1e-6f) << "component " << c;
}

TEST(PbrtDirectives, TransformsCompose) {
  ExpectVec(Place("", {1, 2, 3}), {1, 2, 3});
  ExpectVec(Place("Translate 1 0 0", {1, 2, 3}), {2, 2, 3});
  ExpectVec(Place("Translate [ 1 0 0 ]", {1, 2, 3}), {2, 2, 3});
  ExpectVec(Place("Translate 1 0 0 Scale 2 3 4", {1, 1, 1}), {3, 3, 4});
  ExpectVec(Place("Rotate 90 0 0 1", {1, 0, 0}), {0, 1, 0});
  ExpectVec(Place("Rotate 36000090 0 0 1", {1, 0, 0}), {0, 1, 0});
  ExpectVec(Place("Translate 5 5 5 Identity", {1, 0, 0}), {1, 0, 0});
  // Column by column: the translation is in the last four numbers.
  ExpectVec(Place("Translate 9 9 9 Transform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1]", {0, 0, 0}), {7, 8, 9});
  ExpectVec(Place("Scale 2 2 2 ConcatTransform [0 1 0 0  -1 0 0 0  0 0 1 0  7 8 9 1]", {1, 0, 0}), {14, 18, 18});
  ExpectVec(Place("CoordinateSystem \"here\" Translate 1 1 1 CoordSysTransform \"here\"", {0, 0, 0}), {0, 0, 0});
  ExpectVec(Place("Translate 1 1 1 CoordSysTransform \"world\"", {0, 0, 0}), {0, 0, 0});
  ExpectVec(Place("TransformTimes 0 1 ActiveTransform All Translate 1 1 1", {0, 0, 0}), {1, 1, 1});
  ExpectVec(Place("TransformBegin Translate 1 1 1 TransformEnd", {0, 0, 0}), {0, 0, 0});
  ExpectVec(Place("AttributeBegin Translate 1 1 1 AttributeEnd", {0, 0, 0}), {0, 0, 0});
}

TEST(PbrtDirectives, LookAtIsCameraFromWorldAndNamesTheCamera) {
  const auto scene = Parse(
      "LookAt 1 2 3  1 2 13  0 1 0 Camera \"perspective\" Translate 5 5 5 WorldBegin CoordSysTransform \"camera\" "
      "Shape \"sphere\"");
  ExpectVec(scene.camera.camera_from_world.Point({1, 2, 3}), {0, 0, 0});
  ExpectVec(scene.camera.camera_from_world.Point({1, 2, 8}), {0, 0, 5});  // +z looks at the target
  ExpectVec(scene.camera.camera_from_world.Point({1, 3, 3}), {0, 1, 0});
  ExpectVec(scene.camera.camera_from_world.Point({2, 2, 3}), {1, 0, 0});
  ExpectVec(scene.shapes.at(0).world_from_object.Point({0, 0, 5}), {1, 2, 8});  // "camera" is world-from-camera
}

TEST(PbrtDirectives, RefusesBadTransformsAndBlocks) {
  const Refused cases[] = {
      {"Translate 1 2", kBad, "2:14", "the file ends"},
      {"Translate 1 2 x", kBad, "2:15", "a number"},
      {"Translate [1 2 3 4]", kBad, "2:18", "expected ]"},
      {"Scale 0 1 1", kBad, "2:1", "singular"},
      {"Scale 1e30 1e30 1e30 Scale 1e30 1e30 1e30 Scale 1e-30 1e-30 0", kBad, "2:43", "singular"},
      {"Rotate 90 0 0 0", kBad, "2:1", "axis"},
      {"LookAt 1 1 1 1 1 1 0 1 0", kBad, "2:1", "same point"},
      {"LookAt 0 0 0 0 1 0 0 1 0", kBad, "2:1", "parallel"},
      {"LookAt 0 0 0 0 0 1 0 0 0", kBad, "2:1", "up vector"},
      {"Transform [1 0 0 0  0 1 0 0  0 0 0 0  0 0 0 1]", kBad, "2:1", "singular"},
      {"ConcatTransform [0 0 0 0  0 0 0 0  0 0 0 0  0 0 0 0]", kBad, "2:1", "singular"},
      {"Transform [1 0 0 0]", kBad, "2:19", "a number"},
      {"CoordSysTransform \"nowhere\"", kBad, "2:1", "no coordinate system \"nowhere\""},
      {"CoordinateSystem 5", kBad, "2:18", "in quotes"},
      {"ActiveTransform StartTime", kNo, "2:1", "no motion"},
      {"ActiveTransform EndTime", kNo, "2:1", "no motion"},
      {"ActiveTransform Sometimes", kBad, "2:17", "expected All"},
      {"AttributeBegin", kBad, "2:1", "never ended"},
      {"TransformBegin", kBad, "2:1", "never ended"},
      {"AttributeEnd", kBad, "2:1", "without its AttributeBegin"},
      {"TransformEnd", kBad, "2:1", "without its TransformBegin"},
      {"ObjectEnd", kBad, "2:1", "without its ObjectBegin"},
      {"AttributeBegin TransformEnd", kBad, "2:16", "the open block is the AttributeBegin at s.pbrt:2:1"},
      {"Attribute \"film\" \"float x\" 1", kBad, "2:1", "expected \"shape\""},
      {"Include \"nowhere.pbrt\"", kMissing, "2:1", "no such file"},
      {"Import \"nowhere.pbrt\"", kMissing, "2:1", "no such file"},
  };
  for (const Refused& c : cases) ExpectRefused(c, true);
  ExpectRefused({"Import \"x.pbrt\"", kBad, "1:1", "after WorldBegin"}, false);
  for (const char* directive :
       {"ReverseOrientation", "Material \"diffuse\"", "NamedMaterial \"m\"", "MakeNamedMaterial \"m\"",
        "Texture \"t\" \"float\" \"constant\"", "Shape \"sphere\"", "ObjectBegin \"o\"", "ObjectInstance \"o\"",
        "AreaLightSource \"diffuse\"", "LightSource \"point\""})
    ExpectRefused({directive, kBad, "1:1", "must stand after WorldBegin"}, false);
  for (const char* directive : {"Integrator \"path\"", "Sampler \"sobol\"", "PixelFilter \"box\"", "Film \"rgb\"",
                                "Camera \"perspective\"", "Option \"seed\" 1", "Accelerator \"bvh\""})
    ExpectRefused({directive, kBad, "2:1", "must stand before WorldBegin"}, true);
}

TEST(PbrtDirectives, LenientLeavesOutTheTransformsOfTheShuttersEnd) {
  const auto scene = ParseWorld(
      "Translate 1 0 0 ActiveTransform EndTime Translate 5 0 0 ActiveTransform All Translate 0 1 0 Shape \"sphere\"",
      true);
  ExpectVec(scene.shapes.at(0).world_from_object.Point({0, 0, 0}), {1, 1, 0});
  EXPECT_EQ(scene.left_out.size(), 1u);
}

TEST(PbrtDirectives, BlocksRestoreTheState) {
  const auto scene = ParseWorld(
      "Material \"interface\" AttributeBegin ReverseOrientation Material \"dielectric\" AreaLightSource \"diffuse\" "
      "Shape \"sphere\" AttributeEnd Shape \"sphere\""
      " TransformBegin ReverseOrientation TransformEnd Shape \"sphere\"");
  ASSERT_EQ(scene.shapes.size(), 3u);
  EXPECT_TRUE(scene.shapes[0].reverse_orientation);
  EXPECT_TRUE(scene.shapes[0].light.has_value());
  EXPECT_TRUE(std::holds_alternative<DielectricMaterial>(scene.materials[scene.shapes[0].material].kind));
  EXPECT_FALSE(scene.shapes[1].reverse_orientation);
  EXPECT_FALSE(scene.shapes[1].light.has_value());
  EXPECT_TRUE(std::holds_alternative<InterfaceMaterial>(scene.materials[scene.shapes[1].material].kind));
  EXPECT_TRUE(scene.shapes[2].reverse_orientation);  // TransformEnd restores the transformation only
}

TEST(PbrtDirectives, AttributesAreDefaultsUntilTheirBlockEnds) {
  const auto scene = ParseWorld(
      "AttributeBegin Attribute \"shape\" \"float radius\" 3 \"float height\" 9 Attribute \"light\" \"float scale\" 2 "
      "Attribute \"material\" \"rgb reflectance\" [0 1 0]"
      " Attribute \"texture\" \"float value\" 4 Attribute \"medium\" \"float g\" 0"
      " Material \"diffuse\" Shape \"sphere\" Shape \"sphere\" \"float radius\" 5 Shape \"disk\" LightSource \"point\" "
      "Texture \"t\" \"float\" \"constant\""
      " Attribute \"shape\" \"float radius\" 7 Shape \"sphere\" AttributeEnd Shape \"sphere\"");
  EXPECT_EQ(Get<SphereShape>(scene.shapes.at(0).kind).radius, 3);
  EXPECT_EQ(Get<SphereShape>(scene.shapes.at(1).kind).radius, 5);
  EXPECT_EQ(Get<DiskShape>(scene.shapes.at(2).kind).height, 9);
  EXPECT_EQ(Get<SphereShape>(scene.shapes.at(3).kind).radius, 7);
  EXPECT_EQ(Get<SphereShape>(scene.shapes.at(4).kind).radius, 1);
  EXPECT_EQ(Get<PointLight>(scene.lights.at(0).kind).intensity, Rgb(2));
  EXPECT_EQ(Get<DiffuseMaterial>(scene.materials.at(0).kind).reflectance.value, Rgb(0, 1, 0));
  EXPECT_EQ(Get<ConstantTexture>(scene.textures.at(0).kind).value, Rgb(4));
  // Attributes are typed and refused like the directive's own parameters.
  ExpectRefused(
      {"Attribute \"shape\" \"integer radius\" 3 Shape \"sphere\"", kBad, "2:19", "expected \"float radius\""}, true);
  ExpectRefused({"Attribute \"shape\" \"float phimax\" 90 Shape \"sphere\"", kNo, "2:19", "only whole spheres"}, true);
}

// ---- files
// --------------------------------------------------------------------------------------------------------------------------------

TEST(PbrtFiles, IncludesKeepTheStateAndNameTheirOwnPlaces) {
  TemporaryFolder folder;
  folder.Write("sub/inner.pbrt", "Translate 1 0 0\nShape \"sphere\"\n");
  folder.Write("sub/outer.pbrt",
               "Include \"sub/inner.pbrt\"\nInclude \"inner.pbrt\"\nShape \"plymesh\" \"string filename\" \"m.ply\"");
  folder.Write("sub/m.ply", "");
  const auto file = folder.Write("main.pbrt", "WorldBegin\nInclude \"sub/outer.pbrt\"\nShape \"sphere\"");
  const auto scene = ParsePbrtFile(file);
  ASSERT_EQ(scene.shapes.size(), 4u);
  EXPECT_EQ(scene.shapes[0].where.ToString(), (folder.path() / "sub/inner.pbrt").string() + ":2:1");
  ExpectVec(scene.shapes[3].world_from_object.Point({0, 0, 0}), {2, 0, 0});
  const std::vector<std::string> files = {file.string(), (folder.path() / "sub/outer.pbrt").string(),
                                          (folder.path() / "sub/inner.pbrt").string(),
                                          (folder.path() / "sub/m.ply").string()};
  std::vector<std::string> sorted = scene.files;
  EXPECT_EQ(sorted.at(0), files[0]);
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::string> expected = files;
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(sorted, expected);
}

TEST(PbrtFiles, ImportsLeaveTheStateAsItWas) {
  TemporaryFolder folder;
  folder.Write("part.pbrt",
               "Translate 1 0 0 ReverseOrientation Material \"interface\" CoordinateSystem \"part\" Shape \"sphere\" "
               "MakeNamedMaterial \"m\" \"string type\" \"dielectric\"");
  folder.Write("open.pbrt", "\n AttributeBegin");
  folder.Write("close.pbrt", "AttributeEnd");
  const auto scene = ParsePbrtText(
      "WorldBegin Translate 0 1 0 Import \"part.pbrt\" NamedMaterial \"m\" Shape \"sphere\"", "s.pbrt", folder.path());
  ASSERT_EQ(scene.shapes.size(), 2u);
  ExpectVec(scene.shapes[0].world_from_object.Point({0, 0, 0}), {1, 1, 0});
  ExpectVec(scene.shapes[1].world_from_object.Point({0, 0, 0}), {0, 1, 0});
  EXPECT_FALSE(scene.shapes[1].reverse_orientation);
  EXPECT_TRUE(std::holds_alternative<DielectricMaterial>(scene.materials[scene.shapes[1].material].kind));
  const auto message = [&](const std::string& text) {
    try {
      ParsePbrtText(text, "s.pbrt", folder.path());
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(
      message("WorldBegin Import \"part.pbrt\" CoordSysTransform \"part\"").find("s.pbrt:1:31: no coordinate system"),
      std::string::npos);
  // Shapes of a file that an object's definition imports are the object's.
  const auto object =
      ParsePbrtText("WorldBegin ObjectBegin \"o\" Import \"part.pbrt\" Shape \"sphere\" ObjectEnd Shape \"sphere\"",
                    "s.pbrt", folder.path());
  ASSERT_EQ(object.objects.size(), 1u);
  ASSERT_EQ(object.objects[0].shapes.size(), 2u);
  ExpectVec(object.objects[0].shapes[0].world_from_object.Point({0, 0, 0}), {1, 0, 0});
  EXPECT_EQ(object.shapes.size(), 1u);
  folder.Write("end.pbrt", "ObjectEnd");
  EXPECT_NE(message("WorldBegin ObjectBegin \"o\" Import \"end.pbrt\"")
                .find("end.pbrt:1:1: ObjectEnd where the open block is the Import"),
            std::string::npos);
  EXPECT_NE(message("WorldBegin Import \"open.pbrt\"").find("open.pbrt:2:2: this AttributeBegin"), std::string::npos);
  EXPECT_NE(message("WorldBegin AttributeBegin Import \"close.pbrt\"")
                .find("close.pbrt:1:1: AttributeEnd where the open block is the Import"),
            std::string::npos);
}

// As a worker reads what it was sent: nothing of a file elsewhere is read, nor said.
TEST(PbrtFiles, FilesElsewhereAreRefused) {
  TemporaryFolder outer;
  outer.Write("secret.pbrt", "password");
  outer.Write("scene/sub/part.pbrt", "Include \"../sphere.pbrt\"");
  outer.Write("scene/sphere.pbrt", "Shape \"sphere\"");
  const auto folder = outer.path() / "scene";
  const auto parse = [&](const std::string& text, const std::filesystem::path& within) {
    return ParsePbrtText("WorldBegin\n" + text, "s.pbrt", folder, {.within = within});
  };
  EXPECT_EQ(parse("Include \"sub/part.pbrt\" Include \"sub/../sphere.pbrt\"", folder).shapes.size(), 2u);
  const auto refused = [&](const std::string& text, const std::filesystem::path& within, const std::string& why) {
    try {
      parse(text, within);
      ADD_FAILURE() << text << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(kBad));
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("s.pbrt:2:"), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find("password"), std::string::npos) << error.what();
    }
  };
  const std::string absolute = (outer.path() / "secret.pbrt").string();
  for (const std::string directive :
       {"Include ", "Shape \"plymesh\" \"string filename\" ", "LightSource \"point\" \"spectrum I\" "}) {
    refused(directive + "\"../secret.pbrt\"", folder, "outside of the scene's own files");
    refused(directive + "\"sub/../../secret.pbrt\"", folder, "outside of the scene's own files");
    refused(directive + '"' + absolute + '"', folder, "absolute name");
    refused(directive + '"' + absolute + '"', "/", "absolute name");
  }
  // Relative names alone are asked for, wherever they lead; and without any rule the file is read.
  refused("Include \"../absent.pbrt\"", folder, "outside");
  try {
    parse("Include \"../secret.pbrt\"", "/");
    FAIL() << "was accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("unknown directive \"password\""), std::string::npos) << error.what();
  }
}

TEST(PbrtFiles, RecursionEndsWithAnError) {
  TemporaryFolder folder;
  const auto file = folder.Write("loop.pbrt", "Include \"loop.pbrt\"");
  try {
    ParsePbrtFile(file);
    FAIL() << "was accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("does one include itself?"), std::string::npos) << error.what();
  }
}

TEST(PbrtFiles, ReadsGzipAndRefusesDamage) {
  TemporaryFolder folder;
  const std::string text = "WorldBegin\nShape \"sphere\"\n" + std::string(100000, '#');
  const auto path = folder.path() / "s.pbrt.gz";
  gzFile gz = gzopen(path.c_str(), "wb");
  ASSERT_EQ(gzwrite(gz, text.data(), static_cast<unsigned>(text.size())), static_cast<int>(text.size()));
  gzclose(gz);
  EXPECT_EQ(ParsePbrtFile(path).shapes.size(), 1u);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 9);
  try {
    ParsePbrtFile(path);
    FAIL() << "was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(ErrorKind::kCorrupt));
    EXPECT_NE(std::string(error.what()).find("ends early"), std::string::npos) << error.what();
  }
  EXPECT_THROW(ParsePbrtFile(folder.path() / "absent.pbrt"), Error);
  EXPECT_THROW(ParsePbrtFile(folder.path()), Error);
}

}  // namespace
}  // namespace lodestar
