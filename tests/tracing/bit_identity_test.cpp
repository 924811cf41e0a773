// The same job gives the same bits: image and trees, for any number of threads, any order of units and any cut of a
// round into nodes.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/learning/contribution.h"
#include "core/learning/reduction.h"
#include "tests/statistical/guided_combinations.h"
#include "tests/statistical/small_scenes.h"
#include "tests/support/render.h"
#include "tests/tracing/job_text.h"

namespace lodestar {
namespace {

JobSpec GuidedJob(const std::string& method = "sdtree", std::map<std::string, std::string> options = {}) {
  JobSpec job;
  job.method = method;
  job.options = std::move(options);
  job.budget.spp = 15;
  job.seed = 7;
  return job;
}

// Every method, and what an SD-tree learns from and is made by under other options.
std::vector<JobSpec> GuidedJobs() {
  std::vector<JobSpec> jobs = {
      GuidedJob("sdtree"),
      GuidedJob("focal"),
      GuidedJob("grid", {{"batch", "2"}, {"steps", "4"}}),
      GuidedJob("sdtree+focal"),
      GuidedJob("auto", {{"pilot", "1000"}}),  // so that there is a race in so small a picture
      GuidedJob("sdtree", {{"target", "full"},
                           {"reconstruction", "dense"},
                           {"nee", "kickstart"},
                           {"spatial-filter", "box"},
                           {"directional-filter", "box"},
                           {"lights", "power"},
                           {"roulette", "contribution"}}),
      GuidedJob("sdtree", {{"product", "on"}, {"target", "radiance"}, {"learn", "all"}, {"roulette", "throughput"}}),
      GuidedJob("sdtree",
                {{"bsdf-fraction", "learned-variance"}, {"directional-filter", "nearest"}, {"nee", "never"}})};
  // Long enough for switching to record its full target.
  jobs.push_back(GuidedJob("sdtree", {{"target", "switching"}, {"training", "5"}}));
  jobs.back().budget.spp = 47;
  return jobs;
}

// A scene of coplanar duplicate triangles in several meshes: which of them is hit first must not depend on how a tree
// was built.
std::string DuplicateScene() {
  std::string text = test::Room("");
  for (int i = 0; i < 6; ++i)
    text += "Material \"diffuse\" \"rgb reflectance\" [" + std::to_string(0.1 * (i + 1)) + " 0.5 " +
            std::to_string(0.9 - 0.1 * i) + R"(]
Shape "trianglemesh" "point3 P" [-0.5 -0.5 0  0.5 -0.5 0  0.5 0.5 0  -0.5 0.5 0] "integer indices" [0 1 2 0 2 3  0 1 2 0 2 3]
)";
  return text + R"(LightSource "point" "rgb I" [2 2 2] "point3 from" [0 0 -0.9]
AreaLightSource "diffuse" "rgb L" [3 3 3] "bool twosided" [true]
Shape "disk" "float radius" [0.1] "float height" [-0.5]
)";
}

void ExpectSameImage(const Image& a, const Image& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.pixels.data(), b.pixels.data(), a.size() * sizeof(Rgb)), 0);
  EXPECT_EQ(std::memcmp(a.variance.data(), b.variance.data(), a.size() * sizeof(float)), 0);
}

TEST(BitIdentityTest, ThreadsDoNotShow) {
  for (const JobSpec& job : GuidedJobs()) {
    SCOPED_TRACE(Text(job));
    for (const std::string& text : {DuplicateScene(), test::kSmallScenes[0].text, test::kSmallScenes[1].text,
                                    test::kSmallScenes[2].text, test::kSmallScenes[5].text}) {
      const test::Rendered one = test::RenderText(text, job, 1);
      for (const int threads : {2, 5}) {
        const test::Rendered many = test::RenderText(text, job, threads);
        ExpectSameImage(one.image, many.image);
        EXPECT_TRUE(one.state == many.state);
      }
    }
  }
}

TEST(BitIdentityTest, AnotherSeedShows) {
  JobSpec job = GuidedJob();
  const test::Rendered a = test::RenderText(DuplicateScene(), job);
  job.seed = 8;
  const test::Rendered b = test::RenderText(DuplicateScene(), job);
  EXPECT_NE(std::memcmp(a.image.pixels.data(), b.image.pixels.data(), a.image.size() * sizeof(Rgb)), 0);
}

// Renders rounds in random nodes, in random order, some twice and through bytes, as a farm would.
class ShuffledExecutor final : public Executor {
 public:
  ShuffledExecutor(const CompiledJob& compiled, const JobSpec& job, const Method& method, uint32_t seed)
      : method_(method),
        grid_(compiled.survey.resolution_x, compiled.survey.resolution_y),
        local_(compiled.scene, job, method, 2),
        random_(seed) {}

  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override {
    RoundReduction reduction(method_, state, grid_, round);
    Contribution gathered;
    std::vector<TreeNode> together;
    const auto commit = [&] {
      if (together.empty()) return;
      std::ranges::sort(together, {}, &TreeNode::first);
      const Bytes bytes = SerializeContribution(std::exchange(gathered, {}));
      for (uint32_t copies = 1 + random_() % 2; copies-- > 0;) reduction.Commit(together, bytes);
      together.clear();
    };
    while (!reduction.Complete()) {
      std::vector<TreeNode> nodes = reduction.Missing(random_() % 3);
      std::shuffle(nodes.begin(), nodes.end(), random_);
      for (const TreeNode node : nodes) {
        if (random_() % 4 == 0) continue;  // lost
        // Several nodes may be recorded into one contribution.
        local_.ExecuteNode(state, round, node, stop, &gathered);
        together.push_back(node);
        if (random_() % 2 == 0) commit();
      }
      commit();
    }
    return reduction.Take();
  }

 private:
  const Method& method_;
  TileGrid grid_;
  LocalExecutor local_;
  std::mt19937 random_;
};

// The same job as a farm would render it, several times.
void ExpectSameShuffled(const CompiledJob& compiled, const JobSpec& job, uint32_t shuffles) {
  SCOPED_TRACE(Text(job));
  const test::Rendered plain = test::Render(compiled, job);
  for (uint32_t seed = 1; seed <= shuffles; ++seed) {
    Loop loop(job, compiled.survey);
    ShuffledExecutor executor(compiled, job, loop.method(), seed);
    const StopToken stop;
    loop.Run(executor, stop, {});
    ExpectSameImage(plain.image, loop.Develop());
    EXPECT_TRUE(plain.state == loop.state()->Serialize());
  }
}

TEST(BitIdentityTest, OrderLossAndRepetitionDoNotShow) {
  for (const JobSpec& job : GuidedJobs())
    ExpectSameShuffled(CompileJob(ParsePbrtText(DuplicateScene(), "test.pbrt", "."), job), job, 4);
}

// Lobes that the product looks up in its table.
TEST(BitIdentityTest, NorInAProductOfGlossyLobes) {
  const JobSpec job = GuidedJob("sdtree", {{"product", "on"}});
  ExpectSameShuffled(CompileJob(ParsePbrtText(test::kSmallScenes[1].text, "test.pbrt", "."), job), job, 4);
}

// Whatever a method learns, makes of it and samples by.
TEST(BitIdentityTest, NorUnderOtherOptions) {
  std::vector<JobSpec> jobs;
  for (const auto& [options, scene] : test::GuidedCombinations()) jobs.push_back(GuidedJob("sdtree", options));
  for (const char* learn : {"all", "weighted", "indirect"})
    jobs.push_back(GuidedJob("sdtree", {{"learn", learn}, {"reconstruction", "dense-unlimited"}, {"training", "5"}}));
  for (const char* learn : {"monte-carlo", "sarsa", "expected-sarsa"})
    for (const char* sampling :
         {"inversion-sphere", "rejection", "rejection-mixed", "metropolis", "rejection-memo", "rejection-mixed-memo"})
      jobs.push_back(GuidedJob("grid", {{"learn", learn}, {"sampling", sampling}, {"batch", "2"}, {"steps", "4"}}));
  for (const char* diverging : {"off", "on"}) {
    for (const char* fraction : {"0.5", "learned"})
      jobs.push_back(GuidedJob("focal", {{"bsdf-fraction", fraction}, {"diverging", diverging}}));
    jobs.push_back(GuidedJob("sdtree+focal", {{"diverging", diverging}, {"narrow-by", "guide"}}));
  }
  for (JobSpec& job : jobs) {
    job.budget.spp = test::kCombinationSpp;
    job.resolution_x = job.resolution_y = TileGrid::kTileSize + 1;  // the least of four tiles
  }
  const CompiledJob compiled = CompileJob(ParsePbrtText(DuplicateScene(), "test.pbrt", "."), jobs.front());
  ASSERT_EQ(TileGrid(compiled.survey.resolution_x, compiled.survey.resolution_y).tile_count(), 4u);
  for (const JobSpec& job : jobs) ExpectSameShuffled(compiled, job, 1);
}

// A job of as many passes, after as much training, as a report says.
void ExpectSameReplayed(const CompiledJob& compiled, const test::Rendered& rendered) {
  JobSpec replay = rendered.report.job;
  replay.budget = {.spp = rendered.report.passes};
  replay.training_iterations = rendered.report.training_iterations;
  const test::Rendered again = test::Render(compiled, replay);
  ExpectSameImage(rendered.image, again.image);
  EXPECT_TRUE(rendered.state == again.state);
}

// The jobs above are of scenes whose light is found: focal guiding is not tried under auto.
TEST(BitIdentityTest, NorWhereAutoChoosesFocalGuiding) {
  JobSpec job = GuidedJob("auto", {{"candidates", "path,focal"}, {"pilot", "20000"}});
  // 70 passes of path tracing, ten iterations of 64 passes before focal guiding is judged, one more, and the picture.
  job.budget.spp = 900;
  job.resolution_x = job.resolution_y = TileGrid::kTileSize + 1;  // the least of four tiles
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kPinhole, "test.pbrt", "."), job);
  const test::Rendered one = test::Render(compiled, job, 1);
  ASSERT_TRUE(one.report.choice.starts_with("focal;")) << one.report.choice;
  const test::Rendered many = test::Render(compiled, job, 5);
  ExpectSameImage(one.image, many.image);
  EXPECT_TRUE(one.state == many.state);
  EXPECT_EQ(one.report.choice, many.report.choice);
  ExpectSameShuffled(compiled, job, 1);
  EXPECT_LT(one.report.training_iterations, static_cast<int>(one.report.iterations));
  ExpectSameReplayed(compiled, one);
}

class ReplayTest : public testing::TestWithParam<JobSpec> {};

// Beside what the jobs of this file say, what a method decides from the budget.
std::vector<JobSpec> ReplayedJobs() {
  std::vector<JobSpec> jobs = GuidedJobs();
  jobs.push_back(GuidedJob("grid"));
  return jobs;
}

TEST_P(ReplayTest, ARunByTimeReplaysFromItsReport) {
  JobSpec job = GetParam();
  job.budget = {.seconds = 0.5};
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[0].text, "test.pbrt", "."), job);
  ExpectSameReplayed(compiled, test::Render(compiled, job));
}

INSTANTIATE_TEST_SUITE_P(Of, ReplayTest, testing::ValuesIn(ReplayedJobs()), [](const auto& info) {
  std::string name = info.param.method;
  std::ranges::replace(name, '+', '_');
  return name + "_" + std::to_string(info.index);
});

}  // namespace
}  // namespace lodestar
