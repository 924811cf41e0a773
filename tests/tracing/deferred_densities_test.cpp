// A guide whose densities are dear: the kernel asks for them late, and where no light is met not at all. The light that
// paths bring must not tell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/path_kernel.h"
#include "tests/tracing/cosine_guide.h"
#include "tests/tracing/trace_paths.h"

namespace lodestar {
namespace {

template <bool kDefers>
struct CountingGuide : CosineGuide {
  static constexpr bool kDefersDensities = kDefers;
  uint64_t* densities;
  float Pdf(const Local& local, Vec3 wi) const {
    ++*densities;
    return CosineGuide::Pdf(local, wi);
  }
  GuidedSample Sample(const Local& local, Vec2 u, float more) const {
    ++*densities;
    return CosineGuide::Sample(local, u, more);
  }
  Vec3 Direction(const Local& local, Vec2 u) const { return CosineGuide::Sample(local, u, 0).w; }
};

struct Traced {
  std::vector<Rgb> radiance;
  PathCounters counters;
  uint64_t densities = 0;
};

template <bool kDefers>
Traced Trace(const Scene& scene, const PathSettings& settings) {
  Traced traced;
  const CountingGuide<kDefers> guide{{}, &traced.densities};
  const PathKernel<kEnvironment | kTextures | kSpecular, CountingGuide<kDefers>> kernel(scene, settings, guide);
  traced.counters = TracePaths(scene, kernel, {.width = 12, .height = 12, .passes = 64},
                               [&](Rgb radiance, const auto&) { traced.radiance.push_back(radiance); });
  return traced;
}

// Roulette's factors are rounded in another order, so a path in a million may end elsewhere; none of these does.
void ExpectTheSameLight(const Traced& now, const Traced& later, size_t least_lit) {
  EXPECT_EQ(now.counters.rays, later.counters.rays);
  ASSERT_EQ(now.radiance.size(), later.radiance.size());
  size_t lit = 0;
  for (size_t i = 0; i < now.radiance.size(); ++i) {
    lit += !IsBlack(now.radiance[i]);
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(now.radiance[i][c], later.radiance[i][c], 1e-5f * now.radiance[i][c]) << i << ' ' << c;
  }
  EXPECT_GE(lit, least_lit);
}

constexpr const char* kView = R"(Film "rgb" "integer xresolution" [12] "integer yresolution" [12]
LookAt 0 0 6  0 0 0  0 1 0
Camera "perspective" "float fov" [50]
WorldBegin
)";
// A corner of two diffuse walls, a ball of glass, a lacquered one and a textured disk.
constexpr const char* kCorner = R"(Shape "disk" "float radius" [4] "float height" [-0.5]
AttributeBegin Translate 3 0 0 Rotate 90 0 1 0 Shape "disk" "float radius" [4] AttributeEnd
AttributeBegin Material "dielectric" Translate 1 0.8 1 Shape "sphere" "float radius" [0.6] AttributeEnd
AttributeBegin Material "coateddiffuse" "float roughness" [0.2] Translate 1 -0.8 1
Shape "sphere" "float radius" [0.4] AttributeEnd
Texture "squares" "spectrum" "checkerboard" "float uscale" [5] "float vscale" [5]
AttributeBegin Material "diffuse" "texture reflectance" "squares" Translate -1 0 0
Shape "disk" "float radius" [1] AttributeEnd
)";
constexpr const char* kLamp = R"(AttributeBegin AreaLightSource "diffuse" "rgb L" [8 8 8] Translate 0 2 3
Shape "sphere" "float radius" [1] AttributeEnd
)";
constexpr const char* kSky = R"(LightSource "infinite" "rgb L" [0.3 0.4 0.5]
)";

std::shared_ptr<const Scene> Compiled(const std::string& text) {
  return Scene::Compile(ParsePbrtText(kView + text, "deferred.pbrt", "."));
}

TEST(DeferredDensities, BringTheSameLight) {
  for (const char* light : {kLamp, kSky}) {
    const auto scene = Compiled(std::string(kCorner) + light);
    for (const NextEvent next_event : {NextEvent::kNone, NextEvent::kAll}) {
      SCOPED_TRACE(std::string(light) + std::to_string(static_cast<int>(next_event)));
      const PathSettings settings{.max_depth = 12, .next_event = next_event, .roulette_start = 1};
      const Traced now = Trace<false>(*scene, settings), later = Trace<true>(*scene, settings);
      ExpectTheSameLight(now, later, 200);
      EXPECT_LT(later.densities, now.densities);
    }
  }
}

TEST(DeferredDensities, AreNotAskedForInTheDark) {
  const auto scene = Compiled(kCorner);
  const Traced now = Trace<false>(*scene, {}), later = Trace<true>(*scene, {});
  ExpectTheSameLight(now, later, 0);
  EXPECT_GT(now.densities, 10000u);
  EXPECT_EQ(later.densities, 0u);
}

// More vertices before the light than the kernel keeps waiting.
TEST(DeferredDensities, OfLongPathsBringTheSameLight) {
  const auto scene = Compiled(R"(Material "diffuse" "rgb reflectance" [0.95 0.9 0.8]
AttributeBegin ReverseOrientation Shape "sphere" "float radius" [7] AttributeEnd
AttributeBegin AreaLightSource "diffuse" "rgb L" [800 800 800] Translate 0 2 3
Shape "sphere" "float radius" [0.3] AttributeEnd
)");
  const PathSettings settings{.max_depth = 100, .next_event = NextEvent::kNone, .roulette_start = 100};
  const Traced now = Trace<false>(*scene, settings), later = Trace<true>(*scene, settings);
  EXPECT_GT(now.counters.vertices, 50 * now.counters.paths);
  ExpectTheSameLight(now, later, 200);
}

}  // namespace
}  // namespace lodestar
