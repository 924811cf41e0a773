#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/image/image.h"
#include "core/scene/textures.h"
#include "tests/scene/scene_builder.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using test::SceneBuilder;

TextureDescription Texture(decltype(TextureDescription::kind) kind) {
  return {"t", false, std::move(kind), {"test.pbrt", 4, 2}};
}

TEST(TextureTable, EvaluatesExpressions) {
  std::vector<TextureDescription> textures;
  textures.push_back(Texture(CheckerboardTexture{{Rgb(1)}, {Rgb(0)}, {2, 2, 0, 0}}));
  textures.push_back(Texture(ScaleTexture{{Rgb(), 0}, {Rgb(0.5f, 1, 2)}}));
  textures.push_back(Texture(MixTexture{{Rgb(1)}, {Rgb(), 1}, {Rgb(0.25f)}}));
  textures.push_back(Texture(ConstantTexture{Rgb(3)}));
  textures.push_back(Texture(ScaleTexture{{Rgb(), 3}, {Rgb(2)}}));
  const TextureTable table(textures);
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 0}, {0.1f, 0.1f}), Rgb(1));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 0}, {0.6f, 0.1f}), Rgb(0));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 0}, {-0.1f, 0.1f}), Rgb(0));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 0}, {-0.1f, -0.1f}), Rgb(1));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 1}, {0.1f, 0.1f}), Rgb(0.5f, 1, 2));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 2}, {0.1f, 0.1f}), Rgb(0.875f, 1, 1.25f));
  EXPECT_EQ(table.Evaluate(FloatValue{0, 2}, {0.1f, 0.1f}), 0.875f);
  // Constants fold, what varies does not.
  EXPECT_EQ(table.Fold(RgbValue{Rgb(), 4}).texture, -1);
  EXPECT_EQ(table.Fold(RgbValue{Rgb(), 4}).value, Rgb(6));
  EXPECT_EQ(table.Fold(RgbValue{Rgb(), 1}).texture, 1);
  textures.push_back(Texture(ScaleTexture{{Rgb(), 7}, {Rgb(2)}}));
  EXPECT_THROW(TextureTable{textures}, Error);
}

TEST(TextureTable, ImagesRunUpwardsScaleAndInvert) {
  const TemporaryFolder folder;
  const std::string path = folder / "texture.exr";
  WriteExr(path, FloatImage{1, 2, {Rgb(0.75f), Rgb(0.25f)}});  // upper row brighter
  ImageTexture image;
  image.path = path;
  image.wrap = ImageTexture::Wrap::kClamp;
  ImageTexture inverted = image;
  inverted.invert = true;
  inverted.scale = 2;
  const TextureTable table({Texture(image), Texture(inverted)});
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 0}, {0.5f, 0.9f}), Rgb(0.75f));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 0}, {0.5f, 0.1f}), Rgb(0.25f));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 1}, {0.5f, 0.1f}), Rgb(0.5f));
  EXPECT_EQ(table.Evaluate(RgbValue{Rgb(), 1}, {0.5f, 0.9f}), Rgb(0));
  image.path = "/absent.png";
  try {
    TextureTable{{Texture(image)}};
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kNotFound);
    EXPECT_NE(std::string(e.what()).find("test.pbrt:4:2"), std::string::npos) << e.what();
  }
}

TEST(Materials, TexturesReachTheBsdfAndReflectanceIsClamped) {
  SceneBuilder b;
  b.d.textures.push_back(Texture(CheckerboardTexture{{Rgb(0.25f)}, {Rgb(5)}, {}}));
  b.d.materials[0].kind = DiffuseMaterial{{Rgb(), 0}};
  TriangleMesh quad = test::Quad({0, 0, 0}, {2, 0, 0}, {0, 1, 0});
  quad.uvs = {{0, 0}, {2, 0}, {2, 1}, {0, 1}};
  b.Add(quad);
  const auto scene = b.Compile();
  EXPECT_TRUE(scene->needs().textures);
  for (const float x : {0.5f, 1.5f}) {
    Hit hit;
    const Ray ray{{x, 0.4f, 1}, {0, 0, -1}, kInfinity};
    ASSERT_TRUE(scene->Intersect(ray, &hit));
    const auto si = scene->Interaction(hit);
    EXPECT_NEAR(si.uv.x, x, 1e-6);
    EXPECT_NEAR(si.uv.y, 0.4f, 1e-6);
    EXPECT_NEAR(scene->BsdfAt(si, 0).Albedo({0, 0, 1}).r, x < 1 ? 0.25 : 1, 1e-5);
  }
}

TEST(Materials, MixPicksByAmountAlsoNested) {
  SceneBuilder b;
  b.d.materials = {{"a", DiffuseMaterial{{Rgb(0.1f)}}, {}},
                   {"b", DiffuseMaterial{{Rgb(0.2f)}}, {}},
                   {"c", DiffuseMaterial{{Rgb(0.3f)}}, {}},
                   {"ab", MixMaterial{0, 1, {0.25f}}, {}},
                   {"abc", MixMaterial{3, 2, {0.5f}}, {}}};
  b.Add(test::Quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0})).material = 4;
  const auto scene = b.Compile();
  EXPECT_TRUE(scene->needs().mix);
  Hit hit;
  const Ray ray{{0.3f, 0.4f, 1}, {0, 0, -1}, kInfinity};
  ASSERT_TRUE(scene->Intersect(ray, &hit));
  const auto si = scene->Interaction(hit);
  int counts[4] = {};
  for (int i = 0; i < 1000; ++i)
    ++counts[int(std::round(scene->BsdfAt(si, (i + 0.5f) / 1000).Albedo({0, 0, 1}).r * 10))];
  EXPECT_EQ(counts[1], 375);
  EXPECT_EQ(counts[2], 125);
  EXPECT_EQ(counts[3], 500);
  b.d.materials[3].kind = MixMaterial{4, 1, {0.25f}};
  EXPECT_THROW(b.Compile(), Error);
}

TEST(Alpha, TexturedOpacityHidesPartOfATriangle) {
  SceneBuilder b;
  b.d.textures.push_back(Texture(CheckerboardTexture{{Rgb(1)}, {Rgb(0)}, {}}));
  b.d.textures[0].is_float = true;
  TriangleMesh quad = test::Quad({0, 0, 0}, {2, 0, 0}, {0, 1, 0});
  quad.uvs = {{0, 0}, {2, 0}, {2, 1}, {0, 1}};
  b.Add(quad).alpha.texture = 0;
  const auto scene = b.Compile();
  Hit hit;
  EXPECT_TRUE(scene->Intersect({{0.5f, 0.4f, 1}, {0, 0, -1}, kInfinity}, &hit));
  EXPECT_FALSE(scene->Unoccluded({{0.5f, 0.4f, 1}, {0, 0, -1}, kInfinity}));
  EXPECT_FALSE(scene->Intersect({{1.5f, 0.4f, 1}, {0, 0, -1}, kInfinity}, &hit));
  EXPECT_TRUE(scene->Unoccluded({{1.5f, 0.4f, 1}, {0, 0, -1}, kInfinity}));
}

}  // namespace
}  // namespace lodestar
