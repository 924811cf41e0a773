// Methods made of others must not move the mean: `auto`, which weighs the films of its pilots by variances of their own
// samples, and the mixture of SD-tree and focal field. Against plain path tracing, over independent seeds, by Welch's
// t-test on the image's mean and on each of its quadrants.
#include <gtest/gtest.h>

#include "tests/statistical/image_means.h"
#include "tests/statistical/small_scenes.h"

namespace lodestar {
namespace {

constexpr int kSeeds = 12;
constexpr int kRegions = test::kRegions;

// Every comparison of this file: 6 scenes x 5 variants x 5 regions.
const double kLevel = test::SidakLevel(0.01, 6 * 5 * kRegions);

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

TEST(ComposedMeanTest, AMeanThatIsThreePercentOffIsSeen) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[3].text, "test.pbrt", "."), JobSpec{});
  const test::ImageMeans reference = RenderSeeds(compiled, "path", {}, 1000);
  const test::ImageMeans wrong = RenderSeeds(compiled, "auto", {{"pilot", "1000"}}, 1, 1.03);
  EXPECT_FALSE(test::WelchTest(wrong[4], reference[4], kLevel).accepted);
}

}  // namespace
}  // namespace lodestar
