// Which lights a scene's light samples are of.
#include <gtest/gtest.h>

#include "tests/scene/scene_builder.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using test::Random;
using test::SceneBuilder;

TEST(LightSelection, UnseenLightsAreThoseThatNoPathMeets) {
  SceneBuilder b;
  b.AddLight(test::Quad({-1, -1, 5}, {2, 0, 0}, {0, 2, 0}), Rgb(100));
  EXPECT_FALSE(b.Compile()->needs().unseen_lights);
  EXPECT_FALSE(b.Compile()->SampleUnseenLight({0, 0, 0}, 0.5f, {0.5f, 0.5f}));
  b.AddLight(PointLight{Rgb(1), {0, 0, 2}});
  b.AddLight(DistantLight{Rgb(1), {0, 1, 0}});
  b.AddLight(test::Quad({-1, -1, 3}, {0, 2, 0}, {2, 0, 0}), Rgb(1)).alpha.value = 0;
  const auto scene = b.Compile();
  EXPECT_TRUE(scene->needs().unseen_lights);
  // Each by its probability among all lights over that of the unseen ones.
  enum { kPoint, kDistant, kInvisible, kKinds };
  int counts[kKinds] = {};
  float pdfs[kKinds] = {};
  Random random(8);
  constexpr int kSamples = 30000;
  for (int i = 0; i < kSamples; ++i) {
    const auto s = scene->SampleUnseenLight({0, 0, 0}, random.Next2D().x, {0.5f, 0.5f});
    ASSERT_TRUE(s);
    EXPECT_TRUE(s->delta);
    const int kind = s->infinite ? kDistant : s->target.z < 2.5f ? kPoint : kInvisible;
    ++counts[kind];
    pdfs[kind] = s->pdf;
  }
  for (const int kind : {kPoint, kDistant}) {
    const double share = static_cast<double>(counts[kind]) / kSamples;
    EXPECT_GT(share, 0);
    EXPECT_NEAR(pdfs[kind], share, 4 * std::sqrt(share / kSamples));
  }
  EXPECT_GT(counts[kInvisible], 0);
}

TEST(LightSelection, EveryShiningLightIsPickedAndPowersGuide) {
  SceneBuilder b;
  b.AddLight(PointLight{Rgb(1e-12f), {0, 0, 2}});
  b.AddLight(PointLight{Rgb(0), {0, 0, 3}});
  b.AddLight(PointLight{Rgb(1e12f), {0, 0, 4}});
  const auto scene = b.Compile();
  int dim = 0, black = 0;
  for (int i = 0; i < 4096; ++i) {
    const auto s = scene->SampleLight({0, 0, 0}, i / 4096.0f, {});
    ASSERT_TRUE(s);
    dim += s->target.z == 2;
    black += s->target.z == 3;
  }
  EXPECT_NEAR(dim / 4096.0, 0.005, 0.001);
  EXPECT_EQ(black, 0);
}

}  // namespace
}  // namespace lodestar
