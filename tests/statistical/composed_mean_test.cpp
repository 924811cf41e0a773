// Methods made of others must not move the mean: `auto`, which weighs the films of its pilots by variances of their own
// samples, and the mixture of SD-tree and focal field. Against plain path tracing, over independent seeds, by Welch's
// t-test on the image's mean and on each of its quadrants; where path tracing finds no light to speak of, against focal
// guiding and the known mean.
#include <gtest/gtest.h>

#include "tests/statistical/image_means.h"
#include "tests/statistical/small_scenes.h"

namespace lodestar {
namespace {

constexpr int kSeeds = 12;
constexpr int kRegions = test::kRegions;

// Every comparison of this file: 6 scenes x 5 variants x 5 regions, the pinhole's regions and its two known means.
const double kLevel = test::SidakLevel(0.01, (6 * 5 + 1) * kRegions + 2);

test::ImageMeans RenderSeeds(const CompiledJob& compiled, const std::string& method,
                             const std::map<std::string, std::string>& options, uint64_t first_seed, double scale = 1) {
  JobSpec job;
  job.method = method;
  job.options = options;
  job.budget.spp = 63;
  return test::RenderSeeds(compiled, job, kSeeds, first_seed, scale);
}

class ComposedMeanTest : public testing::TestWithParam<test::SmallScene> {};

TEST_P(ComposedMeanTest, EqualsTheUnguidedMean) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(GetParam().text, "test.pbrt", "."), JobSpec{});
  const test::ImageMeans reference = RenderSeeds(compiled, "path", {}, 1000);
  struct Variant {
    const char* method;
    std::map<std::string, std::string> options;
  };
  // Pilots of two and a few passes: where weights are worst known.
  const std::vector<Variant> variants = {
      {"auto", {{"candidates", "path,sdtree,focal"}, {"pilot", "1000"}}},
      {"auto", {{"candidates", "path,sdtree,product,grid"}, {"pilot", "1000"}}},
      {"auto", {{"candidates", "path,radiance"}, {"pilot", "1000"}}},
      {"sdtree+focal", {{"combine", "discard"}}},
      {"sdtree+focal", {{"combine", "discard"}, {"nee", "never"}, {"initial-iterations", "1"}, {"diverging", "on"}}}};
  for (const Variant& variant : variants) {
    const test::ImageMeans means = RenderSeeds(compiled, variant.method, variant.options, 1);
    for (int region = 0; region < kRegions; ++region) {
      const test::TestResult result = test::WelchTest(means[region], reference[region], kLevel);
      EXPECT_TRUE(result.accepted) << variant.method << " " << testing::PrintToString(variant.options) << ", region "
                                   << region << ": " << result.message;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(SmallScenes, ComposedMeanTest, testing::ValuesIn(test::kSmallScenes),
                         [](const auto& info) { return std::string(info.param.name); });

// The race: 70 passes of path tracing, which has met the light in two or three of its samples, and ten iterations of 64
// passes. The budget has room for one more and the picture.
TEST(ComposedMeanTest, AutoThatChoosesFocalGuidingHasItsMean) {
  constexpr int kPinholeSeeds = 8;
  JobSpec chosen;
  chosen.method = "auto";
  chosen.options = {{"candidates", "path,focal"}, {"pilot", "10000"}};
  chosen.budget.spp = 900;
  chosen.resolution_x = chosen.resolution_y = 12;
  // By itself it would train for half of the budget: too little to be as good.
  JobSpec forced = chosen;
  forced.method = "focal";
  forced.options = {
      {"initial-iterations", "5"}, {"narrowing-iterations", "5"}, {"passes", "64"}, {"combine", "discard"}};
  forced.training_iterations = 10;
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kPinhole, "test.pbrt", "."), chosen);
  const test::ImageMeans reference = test::RenderSeeds(compiled, forced, kPinholeSeeds, 1000);
  test::ImageMeans means, wrong;
  for (int seed = 1; seed <= kPinholeSeeds; ++seed) {
    chosen.seed = static_cast<uint64_t>(seed);
    const test::Rendered rendered = test::Render(compiled, chosen);
    EXPECT_TRUE(rendered.report.choice.starts_with("focal;")) << rendered.report.choice;
    test::AddImage(rendered.image, &means);
    test::AddImage(rendered.image, &wrong, 1.1);
  }
  for (int region = 0; region < kRegions; ++region) {
    const test::TestResult result = test::WelchTest(means[region], reference[region], kLevel);
    EXPECT_TRUE(result.accepted) << region << ": " << result.message;
  }
  EXPECT_FALSE(test::WelchTest(wrong[4], reference[4], kLevel).accepted);
  for (const test::Moments& whole : {means[4], reference[4]}) {
    const test::TestResult result = test::TTest(whole, test::kPinholeMean, kLevel);
    EXPECT_TRUE(result.accepted) << result.message;
  }
}

TEST(ComposedMeanTest, AMeanThatIsThreePercentOffIsSeen) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[3].text, "test.pbrt", "."), JobSpec{});
  const test::ImageMeans reference = RenderSeeds(compiled, "path", {}, 1000);
  const test::ImageMeans wrong = RenderSeeds(compiled, "auto", {{"pilot", "1000"}}, 1, 1.03);
  EXPECT_FALSE(test::WelchTest(wrong[4], reference[4], kLevel).accepted);
}

}  // namespace
}  // namespace lodestar
