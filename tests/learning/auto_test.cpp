// The race behind `auto`, on films whose efficiencies are known.
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/learning/auto_method.h"
#include "core/math/sampler.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

constexpr uint32_t kSide = 48;

// Samples of mean 1 and the given variance: 0 or a rare burst, as noise is in renders.
Film NoisyFilm(uint64_t passes, double variance, uint64_t seed) {
  const TileGrid grid(kSide, kSide);
  Film film(grid);
  const double chance = 1 / (1 + variance), burst = 1 + variance;
  uint64_t state = seed;
  for (uint32_t tile = 0; tile < grid.tile_count(); ++tile) {
    FilmTile out{tile, std::vector<PixelSum>(grid.Rect(tile).pixels())};
    for (PixelSum& sum : out.pixels)
      for (uint64_t pass = 0; pass < passes; ++pass) {
        state += 0x9e3779b97f4a7c15ULL;
        const float u = Sampler::ToUnit(static_cast<uint32_t>(Mix64(state) >> 32));
        sum.Add(Rgb(u < chance ? static_cast<float>(burst) : 0.0f));
      }
    film.Add(grid, out);
  }
  film.AddPasses(static_cast<uint32_t>(passes));
  return film;
}

PixelEstimate Ones() {
  return {kSide, kSide, std::vector<float>(size_t{kSide} * kSide, 1.0f)};
}

TEST(Race, FindsTheRatioOfEfficienciesWithinItsInterval) {
  int covered = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const uint64_t seed = 1000 * static_cast<uint64_t>(trial);
    // Half the variance at one and a half times the cost: four thirds as efficient.
    const PilotResult a = MeasurePilot(0, NoisyFilm(16, 4, seed), 16 * 1.5, Ones()),
                      b = MeasurePilot(1, NoisyFilm(16, 8, seed + 1), 16, Ones());
    const EfficiencyRatio ratio = CompareEfficiency(a, b);
    covered += ratio.low <= 4.0 / 3 && 4.0 / 3 <= ratio.high;
    EXPECT_NEAR(ratio.value, 4.0 / 3, 0.25);
  }
  EXPECT_GE(covered, kTrials * 85 / 100);  // a 95 % interval; 51 of 60 is more than three deviations below
  EXPECT_LT(covered, kTrials);             // and one that always covers would be too wide
}

TEST(Race, AnIntervalAroundAWrongRatioIsSeen) {
  int covered = 0;
  for (uint64_t trial = 0; trial < 20; ++trial) {
    const PilotResult a = MeasurePilot(0, NoisyFilm(16, 4, trial), 16, Ones()),
                      b = MeasurePilot(1, NoisyFilm(16, 8, trial + 99), 16, Ones());
    const EfficiencyRatio ratio = CompareEfficiency(a, b);
    covered += ratio.low <= 3 && 3 <= ratio.high;  // the truth is 2
  }
  EXPECT_EQ(covered, 0);
}

TEST(Race, FilmsWithoutNoiseTie) {
  const PilotResult quiet = MeasurePilot(0, NoisyFilm(4, 0, 1), 4, Ones());
  EXPECT_EQ(CompareEfficiency(quiet, quiet).value, 1);
}

// Drives the method as the loop does, with films of the given variances by candidate and own iteration.
class Driver {
 public:
  explicit Driver(const std::string& candidates = "path,sdtree") {
    JobSpec job;
    job.method = "auto";
    job.options["candidates"] = candidates;
    Survey survey = test::SyntheticSurvey();
    survey.resolution_x = survey.resolution_y = kSide;
    method_ = std::make_unique<AutoMethod>(job, survey);
    state_ = method_->Initial();
  }
  const AutoMethod& method() const { return *method_; }
  const State& state() const { return *state_; }
  std::string active() const { return std::string(method_->ActiveMethod(*state_).name()); }
  // Renders the next iteration; false once the method has decided.
  bool Step(double path_variance, double tree_variance, bool last = false) {
    if (method_->Decided(*state_)) return false;
    const uint64_t passes = method_->IterationPasses(iteration_);
    const double variance = active() == "path" ? path_variance : tree_variance;
    films_.push_back({iteration_, NoisyFilm(passes, variance, 77 + iteration_)});
    const Image image{kSide, kSide, std::vector<Rgb>(size_t{kSide} * kSide, Rgb(1)),
                      std::vector<float>(size_t{kSide} * kSide)};
    // Every pass costs a hundred rays and no vertices, whoever renders it.
    state_ = method_->Advance(state_, {.iteration = iteration_,
                                       .passes = passes,
                                       .image = &image,
                                       .films = films_,
                                       .rays = 100 * passes,
                                       .vertices = 0,
                                       .last = last});
    ++iteration_;
    return true;
  }

 private:
  std::unique_ptr<AutoMethod> method_;
  std::shared_ptr<const State> state_;
  std::vector<IterationFilm> films_;
  uint32_t iteration_ = 0;
};

TEST(Auto, GoesOnWithTheMoreEfficient) {
  Driver trees, paths;
  for (int i = 0; i < 6; ++i) {
    trees.Step(9, 3);
    paths.Step(3, 9);
  }
  EXPECT_EQ(trees.active(), "sdtree");
  EXPECT_FALSE(trees.method().Decided(trees.state()));  // it may train further
  EXPECT_EQ(paths.active(), "path");
  EXPECT_TRUE(paths.method().Decided(paths.state()));
  EXPECT_NE(trees.method().Explain(trees.state()).find("sdtree; path left out: sdtree was 3."), std::string::npos)
      << trees.method().Explain(trees.state());
}

TEST(Auto, PromiseKeepsALearnerUntilItIsBrokenOrKept) {
  // At the end of the pilot the tree is a tenth behind and was improving by a third with each iteration.
  const auto pilot = [](Driver& driver) {
    for (const double tree : {9.0, 12.0, 9.0, 7.0, 5.9, 4.4}) driver.Step(4, tree);
  };
  Driver kept, broken;
  pilot(kept);
  pilot(broken);
  ASSERT_EQ(kept.active(), "sdtree");
  kept.Step(4, 3);
  broken.Step(4, 6);
  EXPECT_EQ(kept.active(), "sdtree");
  EXPECT_EQ(broken.active(), "path");
  EXPECT_TRUE(broken.method().Decided(broken.state()));
}

TEST(Auto, TiesEndAndABudgetThatEndsEarlyTakesWhatItHas) {
  Driver tie;
  for (int i = 0; i < 6; ++i) tie.Step(5, 5);
  EXPECT_LE(static_cast<int>(tie.Step(5, 5)) + static_cast<int>(tie.Step(5, 5)) + static_cast<int>(tie.Step(5, 5)), 3);
  Driver early;
  early.Step(5, 5, true);  // after the pilot of the first candidate
  EXPECT_EQ(early.active(), "path");
}

TEST(Auto, StatesTravelAndBrokenOnesAreRefused) {
  Driver driver;
  for (int i = 0; i < 6; ++i) {
    const Bytes bytes = driver.state().Serialize();
    EXPECT_EQ(driver.method().ParseState(bytes)->Serialize(), bytes);
    Bytes broken = bytes;
    broken[broken.size() / 2] ^= 0x10;
    EXPECT_THROW(driver.method().ParseState(broken), Error);
    driver.Step(9, 3);
  }
  EXPECT_THROW(Driver("path").method().ParseState(driver.state().Serialize()), Error);
}

TEST(Auto, CandidatesAreNamedOnce) {
  for (const char* text : {"", "path,path", "path,tree", "path,", ",path"}) EXPECT_THROW(Driver{text}, Error) << text;
  EXPECT_EQ(Driver("sdtree").active(), "sdtree");
}

}  // namespace
}  // namespace lodestar
