// Groups of lights hold every light once and depend on the scene alone; lights chosen by them come with the density
// that the path kernel assumes.
#include "core/scene/light_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/scene/scene_builder.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using Place = LightGroups::Light::Place;
using test::Random;
using test::SceneBuilder;

const double kLevel = test::SidakLevel(0.01, 8);

std::vector<LightGroups::Light> Lights(int spatial, int distant, int environments) {
  Random random(3);
  std::vector<LightGroups::Light> lights(static_cast<size_t>(spatial + distant + environments));
  double total = 0;
  for (size_t i = 0; i < lights.size(); ++i) {
    const int kind = static_cast<int>(i);
    lights[i].place = kind < spatial             ? Place::kSpatial
                      : kind < spatial + distant ? Place::kDistant
                                                 : Place::kEnvironment;
    const Vec2 xy = random.Next2D();
    lights[i].middle = {10 * xy.x, xy.y, random.Next1D()};
    lights[i].probability = i % 7 == 3 ? 0 : 0.01 + random.Next1D();
    total += lights[i].probability;
  }
  for (auto& light : lights) light.probability /= total;
  return lights;
}

std::vector<uint16_t> SomeWeights(size_t groups) {
  std::vector<uint16_t> weights(groups);
  uint32_t left = 65536;
  for (size_t g = 0; g + 1 < groups; ++g)
    left -= weights[g] = static_cast<uint16_t>(left / (g % 3 == 0 ? 2 * groups : groups));
  weights.back() = static_cast<uint16_t>(left);
  return weights;
}

TEST(LightGroups, AreFewCompleteAndSeparateKinds) {
  for (const auto& [spatial, distant, environments] :
       {std::array{1, 0, 0}, {20, 0, 0}, {500, 3, 2}, {2, 100, 1}, {0, 2, 1}, {5, 0, 3}}) {
    const auto lights = Lights(spatial, distant, environments);
    const LightGroups groups(lights);
    ASSERT_LE(groups.shares().size(), kMaxLightGroups);
    std::vector<double> shares(groups.shares().size());
    std::vector<int> kinds(shares.size(), -1);
    size_t shining = 0;
    for (size_t i = 0; i < lights.size(); ++i) {
      if (lights[i].probability == 0) continue;
      ++shining;
      const uint8_t g = groups.group(i);
      ASSERT_LT(g, shares.size());
      shares[g] += lights[i].probability;
      const int kind = static_cast<int>(lights[i].place);
      EXPECT_TRUE(kinds[g] == -1 || kinds[g] == kind);
      kinds[g] = kind;
    }
    for (size_t g = 0; g < shares.size(); ++g) EXPECT_NEAR(groups.shares()[g], shares[g], 1e-6) << g;
    if (distant == 0 && environments == 0) {
      EXPECT_EQ(shares.size(), std::min<size_t>(shining, kMaxLightGroups));
    }
  }
}

TEST(LightGroups, AreOfLightsNearEachOther) {
  // Two clusters: no group has lights of both.
  std::vector<LightGroups::Light> lights(200);
  for (size_t i = 0; i < lights.size(); ++i)
    lights[i] = {Place::kSpatial, {i % 2 ? 100.0f : 0.0f, 0.01f * static_cast<float>(i), 0}, 0, 1.0 / 200};
  const LightGroups groups(lights), again(lights);
  std::vector<int> cluster(groups.shares().size(), -1);
  for (size_t i = 0; i < lights.size(); ++i) {
    EXPECT_EQ(groups.group(i), again.group(i));
    int& seen = cluster[groups.group(i)];
    EXPECT_TRUE(seen == -1 || seen == static_cast<int>(i % 2));
    seen = static_cast<int>(i % 2);
  }
}

// Do lights come as often as their stated probability, off by `wrong` for one group?
test::TestResult Frequencies(double wrong) {
  const auto lights = Lights(300, 9, 2);
  const LightGroups groups(lights);
  const auto weights = SomeWeights(groups.shares().size());
  constexpr int kCount = 400000;
  std::vector<double> observed(lights.size()), expected;
  Random random(5);
  for (int i = 0; i < kCount; ++i) {
    const auto choice = groups.Sample(weights, random.Next1D());
    EXPECT_EQ(choice.group, groups.group(choice.light));
    EXPECT_EQ(choice.ratio, groups.Ratio(weights, choice.group));
    observed[choice.light] += 1;
  }
  double sum = 0;
  for (size_t i = 0; i < lights.size(); ++i) {
    const double p = lights[i].probability > 0 ? lights[i].probability * groups.Ratio(weights, groups.group(i)) : 0;
    sum += p;
    expected.push_back(kCount * p * (groups.group(i) == 1 ? wrong : 1));
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  return test::ChiSquareTest(observed, expected, kLevel);
}

TEST(LightGroups, LightsComeAsOftenAsStated) {
  const auto result = Frequencies(1);
  EXPECT_TRUE(result.accepted) << result.message;
}

TEST(LightGroups, AWrongShareIsSeen) {
  EXPECT_FALSE(Frequencies(1.15).accepted);
}

TEST(LightGroups, LightsCloserThanTheirSizeStayTogether) {
  // A square of two triangles, and a strip of many.
  for (const auto& [count, expected] : {std::pair{2, 1}, {16, 8}}) {
    std::vector<LightGroups::Light> lights(static_cast<size_t>(count));
    for (size_t i = 0; i < lights.size(); ++i)
      lights[i] = {Place::kSpatial, {0.5f * static_cast<float>(i), 0, 0}, 0.9f, 1.0 / count};
    EXPECT_EQ(LightGroups(lights).shares().size(), static_cast<size_t>(expected));
  }
}

TEST(LightGroups, WeightsOfPowerHaveRatioOne) {
  const LightGroups groups(Lights(100, 2, 1));
  for (uint8_t g = 0; g < groups.shares().size(); ++g) {
    const float share = groups.shares()[g];
    std::vector<uint16_t> weights(groups.shares().size(), 1);
    weights[g] = static_cast<uint16_t>(share * 65536);
    EXPECT_NEAR(groups.Ratio(weights, g), 1, 1 / (share * 65536) + 1e-6);
  }
}

// A sky, a lamp above, a sphere beside it and a point light: every kind of density.
std::shared_ptr<const Scene> MixedScene() {
  SceneBuilder b;
  b.AddLight(test::Quad({-1, -1, 3}, {0, 2, 0}, {2, 0, 0}), Rgb(2));
  b.AddLight(SphereShape{0.5f}, Rgb(5), Transform::Translate({4, 0, 1}));
  b.AddLight(PointLight{Rgb(3), {0, 2, 2}});
  b.AddLight(InfiniteLight{Rgb(0.7f), ""});
  return b.Compile();
}

TEST(LightGroups, SamplesHaveTheDensityThatIsAskedForAfterwards) {
  const auto scene = MixedScene();
  const auto weights = SomeWeights(scene->light_groups().size());
  ASSERT_EQ(weights.size(), 4u);  // the lamp's two triangles are one
  Random random(9);
  std::vector<int> seen(weights.size());
  for (int i = 0; i < 5000; ++i) {
    const float u = random.Next1D();
    const auto s = scene->SampleLight({0, 0, 0}, u, random.Next2D(), weights);
    if (!s) continue;
    ++seen[s->group];
    if (s->delta) continue;
    const Ray ray{{0, 0, 0}, s->wi, kInfinity};
    Hit hit;
    if (s->infinite) {
      EXPECT_NEAR(s->pdf / (scene->Environment(s->wi).pdf * scene->EnvironmentRatio(weights)), 1, 1e-5);
    } else if (scene->Intersect(ray, &hit)) {
      const auto si = scene->Interaction(hit);
      if (si.light < 0) continue;  // past the rim
      EXPECT_NEAR(s->pdf / (scene->LightPdf({0, 0, 0}, si) * scene->LightRatio(weights, si.light)), 1, 1e-3);
    }
  }
  for (const int count : seen) EXPECT_GT(count, 50);
}

// Light arriving from the upper hemisphere, cosine-weighted, by light samples and by directions with the balance
// heuristic, as the kernel combines them.
test::Moments Irradiance(const Scene& scene, LightGroupWeights weights, uint64_t seed, float wrong = 1) {
  Random random(seed);
  test::Moments moments;
  const Vec3 p{0, 0, 0};
  for (int i = 0; i < 60000; ++i) {
    double value = 0;
    const float u = random.Next1D();
    const auto s = scene.SampleLight(p, u, random.Next2D(), weights);
    if (s && s->wi.z > 0 && scene.Unoccluded({p, s->wi, s->infinite ? kInfinity : Length(s->target - p)}))
      value += double(s->radiance.g) * s->wi.z / (s->pdf + (s->delta ? 0 : s->wi.z * kInvPi));
    const Vec3 w = SquareToCosineHemisphere(random.Next2D());
    const Ray ray{p, w, kInfinity};
    Hit hit;
    Rgb radiance;
    float light_pdf = 0;
    if (scene.Intersect(ray, &hit)) {
      const auto si = scene.Interaction(hit);
      radiance = scene.Emitted(si, -w);
      if (!IsBlack(radiance))
        light_pdf = scene.LightPdf(p, si) * (weights.empty() ? 1 : scene.LightRatio(weights, si.light));
    } else {
      const auto sky = scene.Environment(w);
      radiance = sky.radiance;
      light_pdf = sky.pdf * (weights.empty() ? 1 : scene.EnvironmentRatio(weights));
    }
    value += double(radiance.g) * w.z / (w.z * kInvPi + wrong * light_pdf);
    moments.Add(value);
  }
  return moments;
}

TEST(LightGroups, TheMeanDoesNotDependOnTheWeights) {
  const auto scene = MixedScene();
  const auto by_power = Irradiance(*scene, {}, 1);
  const auto weights = SomeWeights(scene->light_groups().size());
  const auto result = test::WelchTest(by_power, Irradiance(*scene, weights, 2), kLevel);
  EXPECT_TRUE(result.accepted) << result.message;
  EXPECT_FALSE(test::WelchTest(by_power, Irradiance(*scene, weights, 2, 0.5f), kLevel).accepted);
}

}  // namespace
}  // namespace lodestar
