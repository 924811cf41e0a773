// Mixes of materials mean the same wherever their parts stand in the file.
#include "core/scene/mix_order.h"

#include <algorithm>

#include "core/scene/scene.h"
#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

const std::string kUse = "NamedMaterial \"abcd\" Shape \"disk\" ";

// A mix of mixes, and everything in it.
std::vector<std::string> Directives() {
  return {R"(MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [.1 .2 .3] )",
          R"(MakeNamedMaterial "b" "string type" "diffuse" "texture reflectance" "s" )",
          R"(MakeNamedMaterial "c" "string type" "thindielectric" )",
          R"(MakeNamedMaterial "ab" "string type" "mix" "string materials" ["a" "b"] "float amount" .25 )",
          R"(MakeNamedMaterial "bc" "string type" "mix" "string materials" ["c" "b"] )",
          R"(MakeNamedMaterial "abcd" "string type" "mix" "string materials" ["ab" "bc"] "float amount" .4 )"};
}

struct Compiled {
  std::string needs;
  std::vector<Rgb> albedos;  // of what the numbers that resolve the mix come to
  bool operator==(const Compiled&) const = default;
};

Compiled Compile(const std::vector<std::string>& world) {
  std::string text = R"(Texture "s" "spectrum" "checkerboard" )";
  for (const std::string& directive : world) text += directive;
  const auto scene = Scene::Compile(ParseWorld(text));
  Hit hit;
  const Ray ray{{0.3f, 0.4f, 1}, {0, 0, -1}, kInfinity};
  EXPECT_TRUE(scene->Intersect(ray, &hit));
  const SurfaceInteraction si = scene->Interaction(hit);
  Compiled compiled{scene->needs().ToString(), {}};
  for (int i = 0; i < 100; ++i)
    compiled.albedos.push_back(scene->BsdfAt(si, (static_cast<float>(i) + 0.5f) / 100).Albedo({0, 0, 1}));
  return compiled;
}

TEST(MixOrder, TheCompiledMixIsTheSameForEveryOrderOfItsDirectives) {
  std::vector<std::string> directives = Directives();
  std::vector<std::string> in_order = directives;
  in_order.push_back(kUse);
  const Compiled expected = Compile(in_order);
  EXPECT_EQ(expected.needs, "textures delta-lobes smooth-lobes transmission mix quadrics");
  EXPECT_EQ(std::count(expected.albedos.begin(), expected.albedos.end(), Rgb(0.1f, 0.2f, 0.3f)), 45);  // .6 * .75

  std::sort(directives.begin(), directives.end());
  do {
    std::vector<std::string> world = directives;
    world.insert(world.begin(), kUse);  // used before anything is known of it
    ASSERT_EQ(Compile(world), expected) << world[1] << world[2] << world[3] << world[4] << world[5];
  } while (std::next_permutation(directives.begin(), directives.end()));
}

TEST(MixOrder, PartsComeFirstAndEachMaterialOnce) {
  // 0 mixes 3 with 2, 2 mixes 3 with 4; 1 stands alone.
  std::vector<MaterialDescription> materials(5);
  materials[0].kind = MixMaterial{3, 2, {}};
  materials[2].kind = MixMaterial{3, 4, {}};
  EXPECT_EQ(PartsBeforeMixes(materials), (std::vector<int>{4, 3, 2, 0, 1}));
  materials[2].kind = MixMaterial{4, 4, {}};
  EXPECT_EQ(PartsBeforeMixes(materials), (std::vector<int>{4, 2, 3, 0, 1}));
}

TEST(MixOrder, DeepNestingNeedsNoDeepStack) {
  std::vector<MaterialDescription> materials(200000);
  for (size_t i = 0; i + 1 < materials.size(); ++i)
    materials[i].kind = MixMaterial{static_cast<int>(i) + 1, static_cast<int>(i) + 1, {}};
  EXPECT_EQ(PartsBeforeMixes(materials).back(), 0);
}

TEST(MixOrder, CirclesAndUnknownMaterialsAreRefusedWithTheirPlace) {
  std::vector<MaterialDescription> materials(3);
  materials[0].kind = MixMaterial{1, 1, {}};
  materials[1].kind = MixMaterial{2, 0, {}};
  materials[1].where = {"s.pbrt", 4, 1};
  const auto message = [&] {
    try {
      PartsBeforeMixes(materials);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("was accepted");
  };
  EXPECT_EQ(message(), "s.pbrt:4:1: this mix of materials contains itself");
  for (const int outside : {-1, 3}) {
    materials[1].kind = MixMaterial{2, outside, {}};
    EXPECT_EQ(message(), "s.pbrt:4:1: this mix of materials names a material that does not exist");
  }
}

}  // namespace
}  // namespace lodestar
