// Focal guiding must not move the mean: its images against plain path tracing, with and without next event estimation,
// over independent seeds, by Welch's t-test on the image's mean and on each of its quadrants.
#include <gtest/gtest.h>

#include "tests/statistical/image_means.h"
#include "tests/statistical/small_scenes.h"

namespace lodestar {
namespace {

constexpr int kSeeds = 10, kRegions = test::kRegions;
using Means = test::ImageMeans;

Means RenderSeeds(const CompiledJob& compiled, const std::string& method,
                  const std::map<std::string, std::string>& options, uint64_t first_seed, double scale = 1) {
  JobSpec job;
  job.method = method;
  job.options = options;
  job.budget.spp = 48;
  return test::RenderSeeds(compiled, job, kSeeds, first_seed, scale);
}

// Scenes x variants x regions.
const double kLevel = test::SidakLevel(0.01, 6 * 5 * kRegions);

class FocalMeanTest : public testing::TestWithParam<test::SmallScene> {};

TEST_P(FocalMeanTest, EqualsTheUnguidedMean) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(GetParam().text, "test.pbrt", "."), JobSpec{});
  const std::map<std::string, std::map<std::string, std::string>> variants = {
      {"never", {{"nee", "never"}}},
      {"always", {{"nee", "always"}}},
      {"learned", {{"bsdf-fraction", "learned"}}},
      {"diverging", {{"diverging", "on"}, {"narrow-factor", "2"}}},
      {"documents", {{"images", "off"}, {"narrow-by", "guide"}}},
  };
  const Means reference = RenderSeeds(compiled, "path", {}, 1000);
  for (auto [name, options] : variants) {
    options["combine"] = "discard";
    const Means guided = RenderSeeds(compiled, "focal", options, 1);
    for (int region = 0; region < kRegions; ++region) {
      const test::TestResult result = test::WelchTest(guided[region], reference[region], kLevel);
      EXPECT_TRUE(result.accepted) << GetParam().name << ", " << name << ", region " << region << ": "
                                   << result.message;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(SmallScenes, FocalMeanTest, testing::ValuesIn(test::kSmallScenes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(FocalMeanTest, AMeanThatIsFivePercentOffIsSeen) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[3].text, "test.pbrt", "."), JobSpec{});
  const Means reference = RenderSeeds(compiled, "path", {}, 1000);
  const Means wrong = RenderSeeds(compiled, "focal", {{"combine", "discard"}}, 1, 1.05);
  EXPECT_FALSE(test::WelchTest(wrong[4], reference[4], kLevel).accepted);
}

// A voxel with nearly all of the mass around shading points: a small light in a corner, on the surfaces it lights.
TEST(FocalMeanTest, LightInTheCornerOfARoom) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::Room(R"(AttributeBegin
AreaLightSource "diffuse" "rgb L" [300 300 300]
Translate 0.95 -0.95 0.95
Shape "sphere" "float radius" [0.05]
AttributeEnd
)"),
                                                        "test.pbrt", "."),
                                          JobSpec{});
  const Means reference = RenderSeeds(compiled, "path", {}, 1000);
  const Means guided = RenderSeeds(compiled, "focal", {{"combine", "discard"}, {"nee", "never"}}, 1);
  for (int region = 0; region < kRegions; ++region) {
    const test::TestResult result = test::WelchTest(guided[region], reference[region], kLevel);
    EXPECT_TRUE(result.accepted) << region << ": " << result.message;
  }
}

}  // namespace
}  // namespace lodestar
