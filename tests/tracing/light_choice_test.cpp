// The kernel picks each of many lights as often as its density says, however few of the vertices sample one.
#include <gtest/gtest.h>

#include "core/scene/light_groups.h"
#include "core/tracing/path_kernel.h"
#include "tests/scene/scene_builder.h"
#include "tests/support/statistical.h"
#include "tests/tracing/cosine_guide.h"

namespace lodestar {
namespace {

constexpr uint32_t kLights = 100000;
constexpr float kShare = 0.1f;  // of the vertices that sample a light
const double kLevel = test::SidakLevel(0.01, 2);

struct FewSamples : CosineGuide {
  LightGroupWeights lights;
  Local At(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) const {
    Local local = CosineGuide::At(si, bsdf, wo);
    local.nee_probability = kShare;
    local.lights = lights;
    return local;
  }
};

// Equal point lights in one place. Red are those that a number of 24 bits would pick too seldom when it is stretched by
// 1 / kShare, blue the others; `pick` says which light a number picks. Counts the paths with light of each colour, and
// those without.
template <class Pick>
void ExpectColoursByTheirNumber(const Pick& pick, LightGroupWeights weights) {
  std::vector<uint32_t> plain(kLights);
  for (uint32_t k = 0; static_cast<float>(k) * 0x1p-24f < kShare; ++k)
    ++plain[pick(static_cast<double>(k) * 0x1p-24 / kShare)];
  test::SceneBuilder b;
  b.Add(test::Quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  double red = 0, red_plain = 0;
  for (const uint32_t count : plain) {
    const bool seldom = count * double{kLights} < 0x1p24 * kShare;
    red += seldom / double{kLights};
    if (seldom) red_plain += count / (0x1p24 * kShare);
    b.AddLight(PointLight{seldom ? Rgb(1, 0, 0) : Rgb(0, 0, 1), {0, 0, 1}});
  }
  const auto scene = b.Compile();
  ASSERT_TRUE(weights.empty() || weights.size() == scene->light_groups().size());

  FewSamples guide;
  guide.lights = weights;
  const PathKernel<0, FewSamples> kernel(*scene, PathSettings{.max_depth = 1}, guide);
  constexpr uint32_t kPaths = 1000000;
  std::vector<double> observed(3);
  PathCounters counters;
  for (uint32_t i = 0; i < kPaths; ++i) {
    Sampler sampler(5, i, 0, 0);
    const Rgb radiance = kernel.Trace({{0, 0, 0.5f}, {0, 0, -1}}, 0, sampler, &counters, nullptr);
    ++observed[radiance.r > 0 ? 0 : radiance.b > 0 ? 1 : 2];
  }
  const auto expected = [](double share) {
    return std::vector{kPaths * kShare * share, kPaths * kShare * (1 - share), kPaths * (1.0 - kShare)};
  };
  const auto result = test::ChiSquareTest(observed, expected(red), kLevel);
  EXPECT_TRUE(result.accepted) << result.message;
  EXPECT_FALSE(test::ChiSquareTest(observed, expected(red_plain), kLevel).accepted);
}

TEST(LightChoice, ByPowerEachOfManyHasItsShare) {
  const AliasTable table(std::vector<double>(kLights, 1.0));
  ExpectColoursByTheirNumber([&](double u) { return table.Sample(u); }, {});
}

TEST(LightChoice, ByLearnedWeightsEachOfManyHasItsShare) {
  LightGroups::Light light;
  light.middle = {0, 0, 1};
  light.probability = 1.0 / kLights;
  const LightGroups groups(std::vector(kLights, light));
  const std::vector<uint16_t> weights(groups.shares().size(), static_cast<uint16_t>(65536 / groups.shares().size()));
  ExpectColoursByTheirNumber([&](double u) { return groups.Sample(weights, u).light; }, weights);
}

}  // namespace
}  // namespace lodestar
