// No combination of the SD-tree's options (guided_combinations.h) may move the mean. Short renders of small pictures,
// so that the whole matrix fits; guided_mean_test.cpp looks at few combinations closely.
#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "core/base/error.h"
#include "tests/statistical/guided_combinations.h"
#include "tests/statistical/image_means.h"
#include "tests/statistical/small_scenes.h"

namespace lodestar {
namespace {

constexpr int kSeeds = 8, kReferenceSeeds = 32;
constexpr int kScenes = test::kCombinationScenes;

using test::Options;

JobSpec SmallJob(const std::string& method, const Options& options) {
  JobSpec job;
  job.method = method;
  job.options = options;
  job.budget.spp = test::kCombinationSpp;
  job.resolution_x = job.resolution_y = 16;
  return job;
}

std::string Text(const Options& options) {
  std::string text;
  for (const auto& [name, value] : options) text += " " + name + "=" + value;
  return text;
}

const double kLevel = test::SidakLevel(0.01, (180 + 2 * 9) * test::kRegions);

class GuidedMatrixTest : public testing::TestWithParam<int> {};

TEST_P(GuidedMatrixTest, NoCombinationMovesTheMean) {
  const test::SmallScene& small = test::kSmallScenes[GetParam()];
  JobSpec size;
  size.resolution_x = size.resolution_y = 16;
  const CompiledJob compiled = CompileJob(ParsePbrtText(small.text, "test.pbrt", "."), size);
  const test::ImageMeans reference = test::RenderSeeds(compiled, SmallJob("path", {}), kReferenceSeeds, 1000);
  for (const auto& [options, scene] : test::GuidedCombinations()) {
    if (scene != GetParam()) continue;
    const test::ImageMeans guided = test::RenderSeeds(compiled, SmallJob("sdtree", options), kSeeds, 1);
    for (int region = 0; region < test::kRegions; ++region) {
      const test::TestResult result = test::WelchTest(guided[region], reference[region], kLevel);
      EXPECT_TRUE(result.accepted) << small.name << ", region " << region << ":" << Text(options) << ": "
                                   << result.message;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(SmallScenes, GuidedMatrixTest, testing::Range(0, kScenes),
                         [](const auto& info) { return std::string(test::kSmallScenes[info.param].name); });

// What ends a path and what samples its lights meet in every scene, with a product and without.
TEST(GuidedMatrixTest, EveryNeeMeetsEveryRouletteInEveryScene) {
  const std::vector<test::GuidedCombination> combinations = test::GuidedCombinations();
  EXPECT_EQ(combinations.size(), 180u);
  std::set<std::tuple<std::string, std::string, std::string, int>> met;
  for (const auto& [options, scene] : combinations)
    met.emplace(options.at("nee"), options.at("roulette"), options.at("product"), scene);
  EXPECT_EQ(met.size(), 4u * 3 * 2 * kScenes);
}

// Learned lights where there are many and of every kind, by what shares their decisions: how often lights are sampled,
// and how directions are.
TEST(GuidedMatrixTest, LearnedLightsDoNotMoveTheMean) {
  for (const test::SmallScene& small : test::kSmallScenes) {
    const std::string name = small.name;
    if (name != "lamps" && name != "spots") continue;
    JobSpec size;
    size.resolution_x = size.resolution_y = 16;
    const CompiledJob compiled = CompileJob(ParsePbrtText(small.text, "test.pbrt", "."), size);
    ASSERT_GE(compiled.survey.light_groups.size(), 2u);
    const test::ImageMeans reference = test::RenderSeeds(compiled, SmallJob("path", {}), kReferenceSeeds, 1000);
    for (const char* nee : {"kickstart", "always", "learned"}) {
      for (const Options& directions : {Options{{"target", "radiance"}}, Options{{"target", "switching"}},
                                        Options{{"product", "on"}, {"target", "radiance"}}}) {
        Options options = {{"lights", "learned"},
                           {"nee", nee},
                           {"combine", "discard"},
                           {"training", "5"},
                           {"spatial-threshold", "200"}};
        options.insert(directions.begin(), directions.end());
        const test::ImageMeans guided = test::RenderSeeds(compiled, SmallJob("sdtree", options), kSeeds, 1);
        for (int region = 0; region < test::kRegions; ++region) {
          const test::TestResult result = test::WelchTest(guided[region], reference[region], kLevel);
          EXPECT_TRUE(result.accepted) << name << ", region " << region << ":" << Text(options) << ": "
                                       << result.message;
        }
      }
    }
  }
}

TEST(GuidedMatrixTest, AMeanThatIsFivePercentOffIsSeen) {
  JobSpec size;
  size.resolution_x = size.resolution_y = 16;
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[0].text, "test.pbrt", "."), size);
  const test::ImageMeans reference = test::RenderSeeds(compiled, SmallJob("path", {}), kReferenceSeeds, 1000);
  const test::ImageMeans wrong =
      test::RenderSeeds(compiled, SmallJob("sdtree", {{"combine", "discard"}, {"training", "5"}}), kSeeds, 1, 1.05);
  EXPECT_FALSE(test::WelchTest(wrong[4], reference[4], kLevel).accepted);
}

TEST(GuidedMatrixTest, ProductsOfOtherTargetsAreRefusedWithTheReason) {
  Survey survey;
  survey.resolution_x = survey.resolution_y = 16;
  for (const char* target : {"simple", "full", "switching"}) {
    try {
      MakeMethod(SmallJob("sdtree", {{"product", "on"}, {"target", target}}), survey);
      FAIL() << target;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("twice"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace lodestar
