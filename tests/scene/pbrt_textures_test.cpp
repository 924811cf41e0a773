#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

TextureDescription Texture(const std::string& text) {
  return ParseWorld("Texture \"t\" " + text).textures.back();
}

TEST(PbrtTextures, Constant) {
  EXPECT_EQ(Get<ConstantTexture>(Texture("\"float\" \"constant\" \"float value\" .25").kind).value, Rgb(0.25f));
  EXPECT_EQ(Get<ConstantTexture>(Texture("\"float\" \"constant\"").kind).value, Rgb(1));
  const auto spectrum = Texture("\"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]");
  EXPECT_EQ(Get<ConstantTexture>(spectrum.kind).value, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_FALSE(spectrum.is_float);
  EXPECT_EQ(spectrum.name, "t");
  EXPECT_EQ(spectrum.where.ToString(), "s.pbrt:2:1");
}

TEST(PbrtTextures, ImageDefaultsArePbrts) {
  const auto texture = Texture("\"float\" \"imagemap\" \"string filename\" \"image.png\"");
  EXPECT_TRUE(texture.is_float);
  const auto image = Get<ImageTexture>(texture.kind);
  EXPECT_EQ(image.path, (Folder() / "image.png").string());
  EXPECT_EQ(image.wrap, ImageTexture::Wrap::kRepeat);
  EXPECT_EQ(image.filter, ImageTexture::Filter::kBilinear);
  EXPECT_EQ(image.encoding, ImageTexture::Encoding::kSrgb);
  EXPECT_EQ(image.scale, 1);
  EXPECT_FALSE(image.invert);
  EXPECT_EQ(image.mapping.su, 1);
  EXPECT_EQ(image.mapping.dv, 0);
}

TEST(PbrtTextures, ImageParameters) {
  const std::string start = "\"spectrum\" \"imagemap\" \"string filename\" \"image.png\" ";
  const auto image = [&](const std::string& params) { return Get<ImageTexture>(Texture(start + params).kind); };
  EXPECT_EQ(image("\"string wrap\" \"repeat\"").wrap, ImageTexture::Wrap::kRepeat);
  EXPECT_EQ(image("\"string wrap\" \"clamp\"").wrap, ImageTexture::Wrap::kClamp);
  EXPECT_EQ(image("\"string wrap\" \"black\"").wrap, ImageTexture::Wrap::kBlack);
  EXPECT_EQ(image("\"string filter\" \"point\"").filter, ImageTexture::Filter::kPoint);
  EXPECT_EQ(image("\"string filter\" \"bilinear\"").filter, ImageTexture::Filter::kBilinear);
  EXPECT_EQ(image("\"string filter\" \"trilinear\"").filter, ImageTexture::Filter::kTrilinear);
  EXPECT_EQ(image("\"string filter\" \"ewa\" \"float maxanisotropy\" 4").filter, ImageTexture::Filter::kEwa);
  EXPECT_EQ(image("\"string filter\" \"EWA\"").filter, ImageTexture::Filter::kEwa);
  EXPECT_EQ(image("\"string encoding\" \"linear\"").encoding, ImageTexture::Encoding::kLinear);
  EXPECT_EQ(image("\"string encoding\" \"sRGB\"").encoding, ImageTexture::Encoding::kSrgb);
  EXPECT_EQ(image("\"string encoding\" \"gamma 2.2\"").encoding, ImageTexture::Encoding::kGamma);
  EXPECT_EQ(image("\"string encoding\" \"gamma 2.2\"").gamma, 2.2f);
  EXPECT_EQ(image("\"float scale\" 2 \"bool invert\" true").scale, 2);
  EXPECT_TRUE(image("\"bool invert\" true").invert);
  const auto mapping =
      image("\"string mapping\" \"uv\" \"float uscale\" 2 \"float vscale\" 3 \"float udelta\" 4 \"float vdelta\" 5")
          .mapping;
  EXPECT_EQ(mapping.su, 2);
  EXPECT_EQ(mapping.sv, 3);
  EXPECT_EQ(mapping.du, 4);
  EXPECT_EQ(mapping.dv, 5);
}

TEST(PbrtTextures, Compositions) {
  const std::string base = "\"f\" \"float\" \"constant\" Texture \"s\" \"spectrum\" \"constant\" Texture \"t\" ";
  const auto parse = [&](const std::string& text) { return ParseWorld("Texture " + base + text).textures.back(); };
  const auto scale =
      Get<ScaleTexture>(parse("\"spectrum\" \"scale\" \"texture tex\" \"s\" \"texture scale\" \"f\"").kind);
  EXPECT_EQ(scale.tex.texture, 1);
  EXPECT_EQ(scale.scale.texture, 0);
  const auto plain = Get<ScaleTexture>(parse("\"float\" \"scale\"").kind);
  EXPECT_EQ(plain.tex.value, Rgb(1));
  EXPECT_EQ(plain.scale.value, Rgb(1));
  const auto mix = Get<MixTexture>(
      parse("\"spectrum\" \"mix\" \"rgb tex1\" [1 0 0] \"texture tex2\" \"s\" \"float amount\" .2").kind);
  EXPECT_EQ(mix.a.value, Rgb(1, 0, 0));
  EXPECT_EQ(mix.b.texture, 1);
  EXPECT_EQ(mix.amount.value, Rgb(0.2f));
  const auto mixed = Get<MixTexture>(parse("\"float\" \"mix\"").kind);
  EXPECT_EQ(mixed.a.value, Rgb(0));
  EXPECT_EQ(mixed.b.value, Rgb(1));
  EXPECT_EQ(mixed.amount.value, Rgb(0.5f));
  const auto checks = Get<CheckerboardTexture>(parse("\"spectrum\" \"checkerboard\" \"integer dimension\" 2 \"texture "
                                                     "tex1\" \"s\" \"rgb tex2\" [0 0 1] \"float uscale\" 8")
                                                   .kind);
  EXPECT_EQ(checks.a.texture, 1);
  EXPECT_EQ(checks.b.value, Rgb(0, 0, 1));
  EXPECT_EQ(checks.mapping.su, 8);
  const auto board = Get<CheckerboardTexture>(parse("\"float\" \"checkerboard\"").kind);
  EXPECT_EQ(board.a.value, Rgb(1));
  EXPECT_EQ(board.b.value, Rgb(0));
}

TEST(PbrtTextures, FloatAndSpectrumNamesAreSeparate) {
  const auto scene = ParseWorld(
      "Texture \"t\" \"float\" \"constant\" Texture \"t\" \"spectrum\" \"constant\" Material \"diffuse\" \"texture "
      "reflectance\" \"t\" Shape \"sphere\" \"texture alpha\" \"t\"");
  EXPECT_EQ(Get<DiffuseMaterial>(scene.materials.at(0).kind).reflectance.texture, 1);
  EXPECT_EQ(scene.shapes.at(0).alpha.texture, 0);
}

TEST(PbrtTextures, RefusesByNameAndPlace) {
  const Refused cases[] = {
      {"Texture \"t\" \"color\" \"constant\"", kBad, "2:13", "\"float\" or \"spectrum\""},
      {"Texture \"t\" float", kBad, "2:13", "\"float\" or \"spectrum\""},
      {"Texture \"t\" \"float\" \"noise\"", kBad, "2:1", "supported here: constant"},
      {"Texture \"t\" \"float\" \"bilerp\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"spectrum\" \"directionmix\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"float\" \"dots\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"float\" \"fbm\" \"integer octaves\" 8", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"spectrum\" \"marble\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"spectrum\" \"ptex\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"float\" \"windy\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"float\" \"wrinkled\"", kNo, "2:1", "use constant, imagemap"},
      {"Texture \"t\" \"float\" \"constant\" Texture \"t\" \"float\" \"constant\"", kBad, "2:32",
       "defined already, at s.pbrt:2:1"},
      {"Texture \"t\" \"float\" \"constant\" \"rgb value\" [1 1 1]", kBad, "2:32", "expected \"float value\""},
      {"Texture \"t\" \"spectrum\" \"constant\" \"float value\" 1", kBad, "2:35", "expected \"rgb value\""},
      {"Texture \"a\" \"float\" \"constant\" Texture \"t\" \"float\" \"constant\" \"texture value\" \"a\"", kBad,
       "2:63", "must be a constant"},
      {"Texture \"t\" \"float\" \"constant\" \"float scale\" 1", kBad, "2:32", "it takes: value"},
      {"Texture \"t\" \"float\" \"imagemap\"", kBad, "2:1", "needs a \"string filename\""},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"\"", kBad, "2:32", "is empty"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"absent.png\"", kMissing, "2:32", "absent.png"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string wrap\" \"mirror\"", kBad,
       "2:62", "repeat, clamp, black"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string wrap\" \"octahedralsphere\"",
       kNo, "2:62", "use repeat"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string filter\" \"cubic\"", kBad,
       "2:62", "point, bilinear"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string encoding\" \"rec709\"", kBad,
       "2:62", "sRGB, linear or gamma"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string encoding\" \"gamma x\"", kBad,
       "2:62", "a number"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string encoding\" \"gamma 0\"", kBad,
       "2:62", "greater than 0"},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string mapping\" \"planar\" \"vector3 "
       "v1\" [1 0 0] \"vector3 v2\" [0 1 0]",
       kNo, "2:62", "only \"uv\""},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string mapping\" \"spherical\"", kNo,
       "2:62", "only \"uv\""},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string mapping\" \"cylindrical\"", kNo,
       "2:62", "only \"uv\""},
      {"Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"image.png\" \"string mapping\" \"cubic\"", kBad,
       "2:62", "expected \"uv\""},
      {"Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 3", kNo, "2:36", "only 2"},
      {"Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 4", kBad, "2:36", "must be 2"},
      {"Texture \"t\" \"spectrum\" \"scale\" \"rgb scale\" [1 1 1]", kBad, "2:32",
       "expected \"float scale\" or \"texture scale\""},
      {"Texture \"t\" \"spectrum\" \"mix\" \"rgb amount\" [1 1 1]", kBad, "2:30", "expected \"float amount\""},
      {"Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"nowhere\"", kBad, "2:30",
       "no spectrum texture of that name"},
      {"Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" [\"a\" \"b\"]", kBad, "2:30", "one texture name"},
      {"Texture \"f\" \"float\" \"constant\" Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"f\"", kBad, "2:61",
       "\"f\" is a float texture"},
  };
  for (const Refused& c : cases) ExpectRefused(c, true);
}

TEST(PbrtTextures, LenientPutsAConstantInPlace) {
  const auto scene =
      ParseWorld("Texture \"t\" \"spectrum\" \"marble\" Material \"diffuse\" \"texture reflectance\" \"t\"", true);
  EXPECT_EQ(Get<DiffuseMaterial>(scene.materials.at(0).kind).reflectance.texture, 0);
  EXPECT_EQ(Get<ConstantTexture>(scene.textures.at(0).kind).value, Rgb(0.5f));
}

}  // namespace
}  // namespace lodestar
