// Grid guiding must not move the mean, whatever its rules: its images against plain path tracing over independent
// seeds, by Welch's t-test on the image's mean and on each of its quadrants. The document's memo does move it, and is
// shown to.
#include <gtest/gtest.h>

#include "tests/statistical/image_means.h"
#include "tests/statistical/small_scenes.h"

namespace lodestar {
namespace {

using Options = std::map<std::string, std::string>;

using Means = test::ImageMeans;
using test::kRegions;

constexpr int kSeeds = 8;

// Four steps of four passes into a small table; the rest is the image.
Means RenderSeeds(const CompiledJob& compiled, const std::string& method, const Options& options, uint64_t first_seed,
                  double scale = 1, int seeds = kSeeds) {
  JobSpec job;
  job.method = method;
  job.options = options;
  if (method == "grid") {
    job.options["combine"] = "discard";
    job.options.insert({{"batch", "4"}, {"steps", "4"}, {"cells", "4"}});
  }
  job.budget.spp = 64;
  return test::RenderSeeds(compiled, job, seeds, first_seed, scale);
}

CompiledJob Compile(const std::string& text) {
  JobSpec job;
  job.resolution_x = job.resolution_y = 12;
  return CompileJob(ParsePbrtText(text, "test.pbrt", "."), job);
}

constexpr const char* kLearning[] = {"monte-carlo", "sarsa", "expected-sarsa"};
constexpr const char* kSampling[] = {"inversion-sphere", "inversion-hemisphere", "rejection", "rejection-mixed",
                                     "metropolis"};
// Learning x sampling on two scenes, four variants on five.
const double kLevel = test::SidakLevel(0.01, (3 * 5 * 2 + 4 * 5) * kRegions);

void ExpectSameMeans(const Means& guided, const Means& reference, const std::string& name) {
  for (int region = 0; region < kRegions; ++region) {
    const test::TestResult result = test::WelchTest(guided[region], reference[region], kLevel);
    EXPECT_TRUE(result.accepted) << name << ", region " << region << ": " << result.message;
  }
}

TEST(GridMeanTest, EveryLearningAndSamplingRuleEqualsTheUnguidedMean) {
  for (const int scene : {0, 3}) {
    const CompiledJob compiled = Compile(test::kSmallScenes[scene].text);
    const Means reference = RenderSeeds(compiled, "path", {}, 1000, 1, 3 * kSeeds);
    for (const std::string learn : kLearning)
      for (const std::string sampling : kSampling) {
        const Means guided =
            RenderSeeds(compiled, "grid", {{"learn", learn}, {"sampling", sampling}, {"bsdf-fraction", "0.2"}}, 1);
        ExpectSameMeans(guided, reference,
                        std::string(test::kSmallScenes[scene].name) + ", " + learn + ", " + sampling);
      }
  }
}

class GridMeanTest : public testing::TestWithParam<test::SmallScene> {};

TEST_P(GridMeanTest, EqualsTheUnguidedMean) {
  const CompiledJob compiled = Compile(GetParam().text);
  const std::map<std::string, Options> variants = {
      {"never", {{"nee", "never"}}},
      {"always", {}},
      {"coarse", {{"cells", "2"}, {"directions", "4"}, {"prior", "0"}}},
      {"fine", {{"cells", "8"}, {"directions", "32"}, {"learn", "expected-sarsa"}}},
  };
  const Means reference = RenderSeeds(compiled, "path", {}, 1000, 1, 3 * kSeeds);
  for (const auto& [name, options] : variants) {
    const Means guided = RenderSeeds(compiled, "grid", options, 1);
    // Without next event estimation fireflies are rare and large: both sides must be as skewed.
    const bool never = options.contains("nee");
    ExpectSameMeans(guided, never ? RenderSeeds(compiled, "path", options, 1000) : reference,
                    std::string(GetParam().name) + ", " + name);
  }
}

INSTANTIATE_TEST_SUITE_P(SmallScenes, GridMeanTest, testing::ValuesIn(test::kSmallScenes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(GridMeanTest, AMeanThatIsFivePercentOffIsSeen) {
  const CompiledJob compiled = Compile(test::kSmallScenes[3].text);
  const Means reference = RenderSeeds(compiled, "path", {}, 1000);
  const Means wrong = RenderSeeds(compiled, "grid", {}, 1, 1.05);
  EXPECT_FALSE(test::WelchTest(wrong[4], reference[4], kLevel).accepted);
}

// BIASED, as it is in the document: kept to be measured. The normalisation belongs to the middle of a cell of normals.
TEST(GridMeanTest, TheDocumentsMemoMovesTheMean) {
  const CompiledJob compiled = Compile(test::kSmallScenes[0].text);
  const Means reference = RenderSeeds(compiled, "path", {}, 1000, 1, 3 * kSeeds);
  for (const std::string sampling : {"rejection", "rejection-mixed"}) {
    const Options options = {{"sampling", sampling}, {"bsdf-fraction", "0.05"}, {"mix", "0.1"}, {"directions", "4"}};
    Options memo = options;
    memo["sampling"] += "-memo";
    EXPECT_TRUE(test::WelchTest(RenderSeeds(compiled, "grid", options, 1)[4], reference[4], kLevel).accepted);
    const test::TestResult result = test::WelchTest(RenderSeeds(compiled, "grid", memo, 1)[4], reference[4], kLevel);
    EXPECT_FALSE(result.accepted) << result.message;
  }
}

TEST(GridMeanTest, OptionsThatMakeNoSenseAreRefused) {
  const CompiledJob compiled = Compile(test::kSmallScenes[0].text);
  for (const Options& options : std::vector<Options>{{{"sampling", "inversion"}},
                                                     {{"directions", "12"}},
                                                     {{"cells", "32"}, {"directions", "32"}},
                                                     {{"bsdf-fraction", "1"}},
                                                     {{"steps", "-1"}},
                                                     {{"alpha", "1"}}}) {
    JobSpec job;
    job.method = "grid";
    job.options = options;
    EXPECT_THROW(MakeMethod(job, compiled.survey), Error);
  }
}

}  // namespace
}  // namespace lodestar
