// What the kernel tells a guide of the roughness at a hit: the same, whoever drew the next direction.
#include <gtest/gtest.h>

#include <map>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/path_kernel.h"
#include "tests/tracing/cosine_guide.h"
#include "tests/tracing/trace_paths.h"

namespace lodestar {
namespace {

struct WithoutAlpha : CosineGuide {
  static constexpr bool kUsesAlpha = false;
};

// How often each roughness was told of each of the three materials below a sky.
using Told = std::map<uint32_t, std::map<float, int>>;
template <class Guide>
Told Trace(const Guide& guide) {
  const auto scene = Scene::Compile(ParsePbrtText(R"(Film "rgb" "integer xresolution" [24] "integer yresolution" [8]
LookAt 0 5 -5  0 0 0  0 1 0
Camera "perspective" "float fov" [40]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "conductor" "float roughness" [0.2] "bool remaproughness" false
AttributeBegin Translate -2 0 0 Rotate -90 1 0 0 Shape "disk" "float radius" [1] AttributeEnd
Material "diffuse"
AttributeBegin Rotate -90 1 0 0 Shape "disk" "float radius" [1] AttributeEnd
Material "coateddiffuse" "float roughness" [0.15] "bool remaproughness" false
AttributeBegin Translate 2 0 0 Rotate -90 1 0 0 Shape "disk" "float radius" [1] AttributeEnd
)",
                                                  "alpha.pbrt", "."));
  const PathKernel<kRecord | kEnvironment, Guide> kernel(*scene, PathSettings{}, guide);
  Told told;
  TracePaths(*scene, kernel, {.width = 24, .height = 8, .passes = 128}, [&](Rgb, const auto& path) {
    for (const PathVertex& vertex : path)
      if (vertex.recorded) ++told[vertex.leaf][vertex.alpha];
  });
  EXPECT_EQ(told.size(), 3u);
  return told;
}

std::vector<float> Roughnesses(const std::map<float, int>& told) {
  std::vector<float> result;
  for (const auto& [alpha, count] : told) {
    EXPECT_GT(count, 10) << alpha;
    result.push_back(alpha);
  }
  return result;
}

TEST(KernelAlpha, ADirectionOfTheGuideHasTheRoughnessOfTheHit) {
  for (const Told& told : {Trace(CosineGuide{.bsdf_fraction = 0}), Trace(CosineGuide{.bsdf_fraction = 1})}) {
    auto metal = told.begin(), diffuse = std::next(metal), coated = std::next(diffuse);
    EXPECT_EQ(Roughnesses(metal->second), std::vector{0.2f});
    EXPECT_EQ(Roughnesses(diffuse->second), std::vector{1.0f});
    EXPECT_EQ(Roughnesses(coated->second), (std::vector{0.15f, 1.0f}));
  }
}

TEST(KernelAlpha, AGuideThatDoesNotUseItIsSparedTheLobes) {
  for (const auto& [material, alphas] : Trace(WithoutAlpha{{.bsdf_fraction = 0}}))
    EXPECT_EQ(Roughnesses(alphas), std::vector{1.0f}) << material;
}

}  // namespace
}  // namespace lodestar
