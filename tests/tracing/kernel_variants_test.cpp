// The variants of the path kernel: each scene gets the smallest that holds what it needs, and what a variant leaves out
// is nothing that its scenes would have met. Paths keep their bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/path_kernel.h"
#include "tests/tracing/cosine_guide.h"
#include "tests/tracing/trace_paths.h"

namespace lodestar {
namespace {

struct Part {
  unsigned feature;
  const char* text;
};
// What a lit corner may have beside its two diffuse walls.
constexpr Part kParts[] = {
    {kEnvironment, R"(LightSource "infinite" "rgb L" [0.3 0.4 0.5])"},
    {kTextures, R"(Texture "squares" "spectrum" "checkerboard" "float uscale" [5] "float vscale" [5]
AttributeBegin Material "diffuse" "texture reflectance" "squares" Translate -1 0 0
Shape "disk" "float radius" [1] AttributeEnd)"},
    {kTextures, R"(MakeNamedMaterial "red" "string type" "diffuse" "rgb reflectance" [0.8 0.1 0.1]
MakeNamedMaterial "metal" "string type" "conductor" "float roughness" [0.2]
MakeNamedMaterial "both" "string type" "mix" "string materials" ["red" "metal"] "float amount" [0.4]
AttributeBegin NamedMaterial "both" Translate -1 0 1
Shape "sphere" "float radius" [0.5] AttributeEnd)"},
    {kSpecular, R"(AttributeBegin Material "dielectric" Translate 1 0.8 1
Shape "sphere" "float radius" [0.6] AttributeEnd)"},
    {kSpecular, R"(AttributeBegin Material "coateddiffuse" "float roughness" [0] Translate 1 -0.8 1
Shape "sphere" "float radius" [0.4] AttributeEnd)"},
    // What a mix has of an interface is opacity, which the intersector knows.
    {kTextures, R"(MakeNamedMaterial "nothing" "string type" "interface"
MakeNamedMaterial "white" "string type" "diffuse"
MakeNamedMaterial "gauze" "string type" "mix" "string materials" ["nothing" "white"] "float amount" [0.3]
AttributeBegin NamedMaterial "gauze" Translate 0 0 1
Shape "sphere" "float radius" [1.7] AttributeEnd)"},
};
constexpr int kPartSets = 1 << std::size(kParts);

std::shared_ptr<const Scene> SceneOf(int set) {
  std::string text = R"(Film "rgb" "integer xresolution" [12] "integer yresolution" [12]
LookAt 0 0 6  0 0 0  0 1 0
Camera "perspective" "float fov" [50]
WorldBegin
AttributeBegin AreaLightSource "diffuse" "rgb L" [8 8 8] Translate 0 4 3 ReverseOrientation
Shape "disk" "float radius" [1] AttributeEnd
Shape "disk" "float radius" [4] "float height" [-0.5]
AttributeBegin Translate 3 0 0 Rotate 90 0 1 0 Shape "disk" "float radius" [4] AttributeEnd
)";
  for (size_t i = 0; i < std::size(kParts); ++i)
    if (set >> i & 1) text += std::string(kParts[i].text) + "\n";
  return Scene::Compile(ParsePbrtText(text, "variants.pbrt", "."));
}

struct Traced {
  std::vector<Rgb> radiance;
  std::vector<PathVertex> vertices;
  PathCounters counters;
};

template <unsigned kFeatures>
Traced Trace(const Scene& scene) {
  const CosineGuide guide;
  const PathKernel<kFeatures, CosineGuide> kernel(scene, PathSettings{.max_depth = 6}, guide);
  Traced traced;
  traced.counters =
      TracePaths(scene, kernel, {.width = 12, .height = 12, .passes = 8}, [&](Rgb radiance, const auto& path) {
        traced.radiance.push_back(radiance);
        // Without an environment nothing is kept of a path that left the scene.
        std::ranges::copy_if(path, std::back_inserter(traced.vertices),
                             [](const PathVertex& v) { return std::isfinite(v.distance) || !IsBlack(v.emitted); });
      });
  return traced;
}

bool SameBits(Rgb a, Rgb b) {
  return std::memcmp(&a, &b, sizeof(Rgb)) == 0;
}
bool SameBits(const PathVertex& a, const PathVertex& b) {
  return SameBits(a.emitted, b.emitted) && SameBits(a.direct, b.direct) && SameBits(a.weight, b.weight) &&
         SameBits(a.beta, b.beta) && a.pdf == b.pdf && a.bsdf_pdf == b.bsdf_pdf && a.distance == b.distance &&
         a.alpha == b.alpha && a.leaf == b.leaf && a.smooth == b.smooth && a.recorded == b.recorded;
}

class KernelVariants : public testing::TestWithParam<int> {};

TEST_P(KernelVariants, ASceneGetsTheSmallestThatHoldsItsNeedsAndLosesNothing) {
  const auto scene = SceneOf(GetParam());
  unsigned expected = 0;
  for (size_t i = 0; i < std::size(kParts); ++i)
    if (GetParam() >> i & 1) expected |= kParts[i].feature;
  const unsigned needed = KernelFeatures(scene->needs());
  ASSERT_EQ(needed, expected);
  const Traced all = Trace<kKernelVariants - 1>(*scene);
  const Traced own =
      WithFeatures<kKernelVariants - 1>(needed | kRecord, [&](auto features) { return Trace<features.value>(*scene); });
  ASSERT_EQ(own.vertices.size(), all.vertices.size());
  EXPECT_EQ(own.counters.rays, all.counters.rays);
  size_t lit = 0;
  for (size_t i = 0; i < own.radiance.size(); ++i) {
    ASSERT_TRUE(SameBits(own.radiance[i], all.radiance[i])) << i;
    lit += !IsBlack(own.radiance[i]);
  }
  EXPECT_GT(lit, own.radiance.size() / 20);
  for (size_t i = 0; i < own.vertices.size(); ++i) ASSERT_TRUE(SameBits(own.vertices[i], all.vertices[i])) << i;
}

// The comparison above sees what is left out wrongly: an environment that the kernel was not compiled for.
TEST(KernelVariants, OneThatIsTooSmallTracesOtherPaths) {
  const auto scene = SceneOf(1);
  const Traced all = Trace<kKernelVariants - 1>(*scene), small = Trace<kRecord>(*scene);
  size_t different = 0;
  for (size_t i = 0; i < all.radiance.size(); ++i) different += !SameBits(all.radiance[i], small.radiance[i]);
  EXPECT_GT(different, all.radiance.size() / 20);
}

INSTANTIATE_TEST_SUITE_P(OfParts, KernelVariants, testing::Range(0, kPartSets));

// A mask's features reach the call, all others are taken off.
TEST(KernelFeatures, OutsideTheMaskHaveNoVariants) {
  constexpr unsigned kMask = kEnvironment | kSpecular;
  for (unsigned features = 0; features < kKernelVariants; ++features)
    EXPECT_EQ(WithFeatures<kMask>(features, [](auto f) { return f.value; }), features & kMask);
}

}  // namespace
}  // namespace lodestar
