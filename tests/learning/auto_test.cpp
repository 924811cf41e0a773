// The race behind `auto`, on films whose efficiencies are known.
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <numeric>

#include "core/base/error.h"
#include "core/learning/auto_method.h"
#include "core/learning/combination.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/math/sampler.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

constexpr uint32_t kSide = 48;

// Samples of mean 1 and the given variance: 0 or a rare burst, as noise is in renders.
Film NoisyFilm(uint64_t passes, double variance, uint64_t seed, uint32_t side = kSide) {
  const TileGrid grid(side, side);
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

Image OnesImage(uint32_t side = kSide) {
  return {side, side, std::vector<Rgb>(size_t{side} * side, Rgb(1)), std::vector<float>(size_t{side} * side)};
}

Yardstick Ones(uint32_t side = kSide) {
  return Yardstick(OnesImage(side));
}

double MeanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
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

// Adds one sample of the given value to a pixel in the middle of a film of noise.
Film WithOutlier(uint64_t passes, double variance, uint64_t seed, float value) {
  Film film = NoisyFilm(passes, variance, seed);
  const TileGrid grid(kSide, kSide);
  FilmTile tile{4, std::vector<PixelSum>(grid.Rect(4).pixels())};
  tile.pixels[100].Add(Rgb(value));
  film.Add(grid, tile);
  return film;
}

TEST(Race, OneOutlierDoesNotDecide) {
  const auto ratio = [](float outlier) {
    return CompareEfficiency(MeasurePilot(0, WithOutlier(16, 4, 1, outlier), 16, Ones()),
                             MeasurePilot(1, NoisyFilm(16, 8, 2), 16, Ones()))
        .value;
  };
  EXPECT_NEAR(ratio(0), 2, 0.3);
  EXPECT_NEAR(ratio(1e6f), 2, 0.3);
}

// What is rare lies in few pixels of a film of few passes: the same share of samples is left out, not of pixels.
TEST(Race, AFilmOfFewPassesIsNoMoreTrimmedThanOneOfMany) {
  constexpr uint32_t kLarge = 512;
  Image slope = OnesImage(kLarge);  // so that no two bursts count alike
  for (size_t i = 0; i < slope.size(); ++i)
    slope.pixels[i] *= 1 + 0.1f * static_cast<float>(i) / static_cast<float>(slope.size());
  const Yardstick yardstick(slope);
  double few = 0, many = 0;
  for (uint64_t seed = 1; seed <= 25; ++seed) {
    few += MeanOf(MeasurePilot(0, NoisyFilm(2, 200, seed, kLarge), 2, yardstick).variances);
    many += MeanOf(MeasurePilot(0, NoisyFilm(16, 200, seed + 99, kLarge), 16, yardstick).variances);
  }
  EXPECT_NEAR(few / many, 1, 0.03);  // 0.965 with as many pixels left out of both
}

// The yardstick holds every film. Where one has met a rare sample, that must not be what is expected there.
TEST(Race, AFilmsOutliersDoNotHideInTheYardstick) {
  double rare_variance = 0, other_variance = 0;
  for (uint64_t trial = 0; trial < 20; ++trial) {
    const Film rare = NoisyFilm(2, 500, trial), other = NoisyFilm(7, 20, trial + 100);
    Image image = rare.Develop();
    const Image others = other.Develop();
    for (size_t i = 0; i < image.size(); ++i)
      image.pixels[i] = image.pixels[i] * (2 / 9.0f) + others.pixels[i] * (7 / 9.0f);
    const Yardstick yardstick(image);
    rare_variance += MeanOf(MeasurePilot(0, rare, 2, yardstick).variances);
    other_variance += MeanOf(MeasurePilot(1, other, 7, yardstick).variances);
  }
  EXPECT_NEAR(rare_variance / other_variance, 500 / 20.0, 6);
}

TEST(Race, AFilmThatHasNotMetTheLightIsNoisy) {
  const PilotResult found = MeasurePilot(0, NoisyFilm(16, 100, 1), 16, Ones());
  // No sample met anything, so no variance shows. 36 pixels of 16 samples a block: one sample in 576 or fewer.
  const PilotResult black =
      MeasurePilot(1, NoisyFilm(16, 0, 1), 16,
                   Yardstick(Image{kSide, kSide, std::vector<Rgb>(size_t{kSide} * kSide, Rgb(1e6f)),
                                   std::vector<float>(size_t{kSide} * kSide)}));
  for (const double variance : black.variances) EXPECT_NEAR(variance, 576 / (1 + kRelMseEpsilon), 0.1);
  EXPECT_GT(CompareEfficiency(found, black).value, 4);
}

TEST(Race, TheUnitOfLightDoesNotMatter) {
  const auto measured = [](float unit) {
    const TileGrid grid(kSide, kSide);
    Film film(grid);
    std::vector<Rgb> pixels(size_t{kSide} * kSide);
    for (uint32_t tile = 0; tile < grid.tile_count(); ++tile) {
      const TileRect rect = grid.Rect(tile);
      FilmTile out{tile, std::vector<PixelSum>(rect.pixels())};
      for (uint32_t i = 0; i < rect.pixels(); ++i) {
        const uint32_t x = rect.x0 + i % rect.width(), y = rect.y0 + i / rect.width();
        const float mean = x < kSide / 2 ? 0.01f : 1.0f;
        pixels[size_t{y} * kSide + x] = Rgb(unit * mean);
        for (int pass = 0; pass < 4; ++pass) out.pixels[i].Add(Rgb(unit * mean * (pass % 2 == 0 ? 1.5f : 0.5f)));
      }
      film.Add(grid, out);
    }
    film.AddPasses(4);
    return MeasurePilot(0, film, 4, Yardstick({kSide, kSide, pixels, std::vector<float>(pixels.size())}));
  };
  const PilotResult one = measured(1);
  EXPECT_LT(one.variances.front(), 0.5 * one.variances.back());  // the dark half counts for less than its due
  for (const float unit : {1e-6f, 1e6f}) {
    const PilotResult scaled = measured(unit);
    for (size_t block = 0; block < one.variances.size(); ++block)
      EXPECT_NEAR(scaled.variances[block] / one.variances[block], 1, 1e-4) << unit;
  }
}

TEST(Race, RelativeVarianceIsAboutOneOverTheShareOfHits) {
  EXPECT_NEAR(RelativeVariance(NoisyFilm(32, 200, 5)) / 200, 1, 0.15);
  EXPECT_EQ(RelativeVariance(NoisyFilm(1, 0, 5)), std::numeric_limits<double>::infinity());
  const TileGrid grid(kSide, kSide);
  Film black(grid);
  black.AddPasses(8);
  EXPECT_EQ(RelativeVariance(black), std::numeric_limits<double>::infinity());
}

// Drives the method as the loop does, with films of given variances; films are kSide wide, whatever the job's picture.
class Driver {
 public:
  explicit Driver(const std::string& candidates = "path,sdtree", uint32_t width = 320, uint32_t height = 180,
                  bool guidable = true, const std::string& credit = "-1") {
    JobSpec job;
    job.method = "auto";
    job.options["candidates"] = candidates;
    job.options["credit"] = credit;
    Survey survey = test::SyntheticSurvey();
    survey.resolution_x = width;
    survey.resolution_y = height;
    survey.guidable = guidable;
    method_ = std::make_unique<AutoMethod>(job, survey);
    state_ = method_->Initial();
  }
  const AutoMethod& method() const { return *method_; }
  const State& state() const { return *state_; }
  Method::Active now() const { return method_->ActiveUnder(state_); }
  std::string active() const { return std::string(now().method->name()); }
  const AutoState::Parts& parts() const { return dynamic_cast<const AutoState&>(*state_).parts(); }
  bool settled() const { return parts().settled; }
  uint32_t iterations() const { return iteration_; }
  const std::vector<IterationFilm>& films() const { return films_; }
  uint64_t passes() const { return method_->IterationPasses(*state_, iteration_); }
  // Renders the next iteration, its samples of the given variance; false once the method has decided.
  bool Step(double variance, bool last = false, bool late = false) {
    if (method_->Decided(*state_)) return false;
    const uint64_t rendered = passes(), counted = std::min<uint64_t>(rendered, 32);
    // Every pass costs a hundred rays and no vertices, whoever renders it.
    films_.push_back({iteration_, NoisyFilm(counted, variance, same_noise_ ? 77 : 77 + iteration_),
                      method_->ActiveUnder(state_).candidate, 100 * counted, 0});
    const Image image = OnesImage();
    state_ = method_->Advance(
        state_,
        {.iteration = iteration_, .passes = rendered, .image = &image, .films = films_, .last = last, .late = late});
    MakeRoom(&films_, method_->combination(), Combine(films_, method_->combination()).weights);
    ++iteration_;
    return true;
  }
  // Films of as many passes are the same bits from here on.
  void RepeatNoise() { same_noise_ = true; }
  // Until the race is over; the candidates' variances by name. Passes of all iterations.
  uint64_t Race(const std::map<std::string, double>& variances) {
    uint64_t sum = 0;
    while (!settled()) {
      sum += passes();
      Step(variances.at(active()));
    }
    return sum;
  }

 private:
  std::unique_ptr<AutoMethod> method_;
  std::shared_ptr<const State> state_;
  std::vector<IterationFilm> films_;
  uint32_t iteration_ = 0;
  bool same_noise_ = false;
};

TEST(Auto, GoesOnWithTheMoreEfficient) {
  Driver trees, paths;
  trees.Race({{"path", 9}, {"sdtree", 3}});
  paths.Race({{"path", 3}, {"sdtree", 9}});
  EXPECT_EQ(trees.active(), "sdtree");
  EXPECT_FALSE(trees.method().Decided(trees.state()));  // it may train further
  EXPECT_EQ(paths.active(), "path");
  EXPECT_TRUE(paths.method().Decided(paths.state()));
  const std::string text = trees.method().Explain(trees.state());
  EXPECT_TRUE(text.starts_with("sdtree; path left out: sdtree was ")) << text;
}

TEST(Auto, ATenthIsTold) {
  int right = 0;
  for (uint32_t width = 300; width < 320; ++width) {  // another seed each
    Driver driver("path,sdtree", width);
    driver.Race({{"path", 4}, {"sdtree", width % 2 == 0 ? 3.6 : 4.6}});
    right += driver.active() == (width % 2 == 0 ? "sdtree" : "path");
  }
  EXPECT_GE(right, 17);
}

TEST(Auto, PromiseKeepsALearnerUntilItIsBrokenOrKept) {
  // At the end of the pilot the tree is a fifth behind and was improving by two fifths with each iteration.
  const auto pilot = [](Driver& driver) {
    for (const double variance : {4.0, 9.0, 12.0, 9.0, 6.7, 4.8}) driver.Step(variance);
  };
  Driver kept, broken;
  pilot(kept);
  pilot(broken);
  ASSERT_EQ(kept.active(), "sdtree");
  ASSERT_FALSE(kept.settled());
  kept.Step(3);
  broken.Step(6);
  EXPECT_EQ(kept.active(), "sdtree");
  EXPECT_EQ(broken.active(), "path");
  EXPECT_TRUE(broken.method().Decided(broken.state()));
}

// In large pictures a pilot has two passes of path tracing, and one and two of a tree, of which two are measured.
TEST(Auto, OneFilmDoesNotTellHowALearnerGrows) {
  const auto after_pilot = [](double tree, bool last, bool late, const char* credit = "-1") {
    Driver driver("path,sdtree", 1280, 720, true, credit);
    driver.Step(4);
    driver.Step(9);
    driver.Step(tree, last, late);
    return driver;
  };
  Driver grows = after_pilot(6.4, false, false), stays = after_pilot(6.4, false, false);
  ASSERT_EQ(grows.active(), "sdtree");
  ASSERT_FALSE(grows.settled());
  grows.Step(3);
  stays.Step(6.4);
  EXPECT_EQ(grows.active(), "sdtree");
  EXPECT_EQ(stays.active(), "path");
  EXPECT_TRUE(stays.settled());
  // Not where it could not be seen any more or it is late, nor where growth would not make up for it.
  for (const Driver& driver : {after_pilot(6.4, true, false), after_pilot(6.4, false, true),
                               after_pilot(6.4, false, false, "3"), after_pilot(14, false, false)}) {
    EXPECT_EQ(driver.active(), "path");
    EXPECT_TRUE(driver.settled());
  }
  // Who leads in fact goes on learning, and who is told until when there is credit does not ask.
  EXPECT_FALSE(after_pilot(2, false, true).method().Decided(after_pilot(2, false, true).state()));
  EXPECT_EQ(after_pilot(6.4, false, true, "4").active(), "sdtree");
}

// For a replay: until when there was credit.
TEST(Auto, SaysWhenItWasLate) {
  Driver driver("path,sdtree", 1280, 720);
  const auto credit = [&] { return driver.method().DecidedOptions(driver.state()).at("credit"); };
  driver.Step(4);
  driver.Step(9);
  EXPECT_EQ(credit(), "3");  // not yet late
  driver.Step(6.4, false, true);
  EXPECT_EQ(credit(), "3");
  driver.Step(4, false, true);
  EXPECT_EQ(credit(), "3");
  EXPECT_TRUE(Driver("path").method().DecidedOptions(Driver("path").state()).empty());
}

TEST(Auto, ABudgetThatEndsEarlyTakesWhatItHas) {
  Driver early;
  early.Step(5, true);  // after the pilot of the first candidate
  EXPECT_EQ(early.active(), "path");
  EXPECT_TRUE(early.settled());
  Driver young;
  for (int i = 0; i < 3; ++i) young.Step(young.active() == "path" ? 9 : 3, i == 2);
  EXPECT_EQ(young.active(), "sdtree");
  EXPECT_TRUE(young.settled());
}

TEST(Auto, APilotIsANumberOfPathsWhateverTheSize) {
  struct Size {
    uint32_t width, height;
  };
  for (const Size size : {Size{16, 16}, Size{160, 120}, Size{320, 180}, Size{512, 512}, Size{1280, 720},
                          Size{1920, 1080}, Size{3840, 2160}}) {
    const double pixels = double{1} * size.width * size.height;
    // Ties take longest, and end.
    const auto passes =
        static_cast<double>(Driver("path,sdtree", size.width, size.height).Race({{"path", 5}, {"sdtree", 5}}));
    // Path tracing's half a million, and up to the power of two beyond three times as many, twice for a probation; or
    // two passes and three.
    EXPECT_LE(passes, std::max(5.0, 3 + (1 + 4 * 3) * 580000 / pixels)) << size.width;
    EXPECT_GE(passes, 4 * 580000 / pixels) << size.width;
  }
}

// All six, as good as each other to the bit (but the grid, whose films have eight passes): nobody who learns goes on
// for a tie, and the race ends with the pilots.
TEST(Auto, ARaceOfEqualsEndsWithItsPilots) {
  Driver driver("path,sdtree,radiance,product,grid,focal", 100, 80);
  driver.RepeatNoise();
  // Half a million paths of path tracing; ten iterations of focal guiding, of a quarter of a million paths; trees up to
  // the power of two beyond three times as many; all the steps of a grid.
  constexpr uint64_t kPilots = 73 + 10 * 32 + 3 * 255 + 16 * 8;
  uint64_t passes = 0;
  while (!driver.settled() && passes < 2 * kPilots) {
    passes += driver.passes();
    driver.Step(3000);
  }
  EXPECT_TRUE(driver.settled());
  EXPECT_LE(passes, kPilots);
  EXPECT_TRUE(driver.method().Decided(driver.state())) << driver.active();
  for (const AutoState::Entrant& entrant : driver.parts().entrants) EXPECT_GT(entrant.passes, 0u);
}

TEST(Auto, FocalGuidingRacesWherePathTracingHardlyFindsTheLight) {
  const std::string all = "path,sdtree,focal";
  Driver lit(all), dark(all);
  lit.Race({{"path", 40}, {"sdtree", 20}});
  EXPECT_NE(lit.method().Explain(lit.state()).find("focal not tried: path tracing finds the light"), std::string::npos);
  dark.Race({{"path", 9000}, {"sdtree", 6000}, {"focal", 50}});
  EXPECT_EQ(dark.active(), "focal");
  EXPECT_FALSE(dark.method().Decided(dark.state()));
  // A tree begins as path tracing, which is 180 times behind: it has no turn.
  EXPECT_EQ(dark.parts().entrants[2].passes, 0u);
  EXPECT_NE(dark.method().Explain(dark.state()).find("sdtree not tried: focal led by more than it could have gained"),
            std::string::npos);
  Driver twilight(all);
  twilight.Race({{"path", 4000}, {"sdtree", 900}, {"focal", 900}});
  EXPECT_GT(twilight.parts().entrants[2].passes, 0u);
}

// Before focal guiding has narrowed it may look worse than path tracing by any factor.
TEST(Auto, FocalGuidingIsJudgedAtTheEndOfItsPilot) {
  Driver driver("path,sdtree,focal");
  driver.Step(3000);
  while (driver.active() == "focal" && driver.parts().entrants[1].iterations < 9) driver.Step(300000);
  ASSERT_EQ(driver.active(), "focal");
  driver.Race({{"path", 3000}, {"sdtree", 3000}, {"focal", 20}});
  EXPECT_EQ(driver.active(), "focal");
}

// A small picture and many candidates: more than forty iterations in the pilots, and who came first is still compared.
TEST(Auto, ARaceOfManyIterationsForgetsNobody) {
  Driver driver("path,sdtree,product,grid,focal", 40, 24);
  driver.Race({{"path", 2000}, {"sdtree", 1000}, {"grid", 1000}, {"focal", 1000}});
  EXPECT_GT(driver.iterations(), 40u);
  EXPECT_LE(driver.films().size(), 5u * 3);
  const std::string text = driver.method().Explain(driver.state());
  EXPECT_EQ(text.find("not "), std::string::npos) << text;  // neither "not measured" nor "not tried"
}

TEST(Auto, LosersStopEarly) {
  // The tree's pilot has 1, 2, 4, 8 and 16 passes. At best it would be 1.5^4 = 5 times as good a while after it.
  const auto passes = [](double variance) { return Driver().Race({{"path", 4}, {"sdtree", variance}}); };
  EXPECT_EQ(passes(60), 11u + 1 + 2);
  EXPECT_EQ(passes(12), 11u + 1 + 2 + 4 + 8);  // three times behind, with one to come and one more
  EXPECT_EQ(passes(6), 11u + 31);
  Driver loser;
  loser.Race({{"path", 4}, {"sdtree", 60}});
  EXPECT_EQ(loser.active(), "path");
  EXPECT_NE(loser.method().Explain(loser.state()).find("sdtree left out: path was "), std::string::npos);
}

// Their states are not sent with every unit while the others race on.
TEST(Auto, WhoHasLostForGoodHasNoState) {
  const auto second = [](double tree) {
    Driver driver("path,sdtree,grid");
    while (driver.active() != "grid") driver.Step(driver.active() == "path" ? 4 : tree);
    return driver;
  };
  const Driver lost = second(60), close = second(4.2);
  EXPECT_FALSE(lost.settled());
  EXPECT_EQ(lost.parts().entrants[1].state, nullptr);
  EXPECT_NE(lost.parts().entrants[0].state, nullptr);
  EXPECT_NE(close.parts().entrants[1].state, nullptr);
  EXPECT_LT(2 * lost.state().Serialize().size(), close.state().Serialize().size());
  const Bytes bytes = lost.state().Serialize();
  EXPECT_EQ(lost.method().ParseState(bytes)->Serialize(), bytes);
}

TEST(Auto, TheRaceGoesOnWithoutTheLost) {
  // The second tree leads by its promise alone, as above, and path tracing waits for its chance; the first had lost.
  Driver driver("path,sdtree,product");
  driver.Step(4);
  while (driver.now().candidate == 1) driver.Step(60);
  for (const double variance : {9.0, 12.0, 9.0, 6.7, 4.8}) driver.Step(variance);
  ASSERT_EQ(driver.now().candidate, 2u);
  ASSERT_FALSE(driver.settled());
  const std::string text = driver.method().Explain(driver.state());
  EXPECT_NE(text.find("path waits: product, which still learns, was "), std::string::npos) << text;
  EXPECT_NE(text.find("sdtree left out: product was "), std::string::npos) << text;
  const Bytes bytes = driver.state().Serialize();
  EXPECT_EQ(driver.method().ParseState(bytes)->Serialize(), bytes);
  driver.Step(6);
  EXPECT_EQ(driver.active(), "path");
  EXPECT_TRUE(driver.method().Decided(driver.state()));
}

// By what doubt allows, the tree leads path tracing and the grid the tree, and path tracing the grid in fact: no reason
// to go on with a grid that has nothing to learn any more.
TEST(Auto, WhoHasLearnedAllLeadsInFactOrNotAtAll) {
  for (const uint32_t width : {90, 96, 102}) {
    Driver driver("path,sdtree,grid", width, 96);
    const std::map<std::string, double> variances = {{"path", 4.0}, {"sdtree", 4.02}, {"grid", 4.02}};
    while (!driver.settled()) {
      ASSERT_GT(driver.passes(), 0u) << width;
      driver.Step(variances.at(driver.active()));
    }
  }
}

// Path tracing finds the light: focal guiding will not be tried, and has nothing to send from then on.
TEST(Auto, WhoIsPassedOverHasNoState) {
  Driver driver("path,sdtree,focal");
  driver.Step(4);
  EXPECT_EQ(driver.active(), "sdtree");
  EXPECT_EQ(driver.parts().entrants[1].state, nullptr);
}

// Path tracing was still ahead in fact: who goes on by its promise does so for good, and alone.
TEST(Auto, AfterTheLastIterationTheChosenAloneIsKept) {
  Driver driver;
  for (const double variance : {4.0, 9.0, 12.0, 9.0, 6.7}) driver.Step(variance);
  driver.Step(4.8, true);
  ASSERT_EQ(driver.active(), "sdtree");
  EXPECT_TRUE(driver.settled());
  EXPECT_EQ(driver.parts().entrants[0].state, nullptr);
  const std::string text = driver.method().Explain(driver.state());
  EXPECT_NE(text.find("path left out: sdtree, which still learns, was 0."), std::string::npos) << text;
}

TEST(Auto, AStateWithoutWhoIsStillToRaceIsRefused) {
  Driver driver("path,sdtree,grid");
  while (driver.active() != "sdtree") driver.Step(4);
  for (const size_t c : {0, 1, 2}) {
    AutoState::Parts parts = driver.parts();
    parts.entrants[c].state = nullptr;
    EXPECT_THROW(driver.method().ParseState(AutoState(parts).Serialize()), Error) << c;
  }
}

TEST(Auto, NothingIsTriedThatTheSceneHasNothingFor) {
  Driver mirrors("path,sdtree,focal", 320, 180, false);
  EXPECT_TRUE(mirrors.settled());
  EXPECT_EQ(mirrors.active(), "path");
  EXPECT_TRUE(
      mirrors.method().Explain(mirrors.state()).starts_with("path; focal left out: the scene has no light, or"));
  EXPECT_EQ(Driver("sdtree", 320, 180, false).active(), "sdtree");  // who asks for it alone gets it
}

TEST(Auto, StatesTravelAndBrokenOnesAreRefused) {
  Driver driver;
  for (int i = 0; i < 6; ++i) {
    const Bytes bytes = driver.state().Serialize();
    EXPECT_EQ(driver.method().ParseState(bytes)->Serialize(), bytes);
    Bytes broken = bytes;
    broken[broken.size() / 2] ^= 0x10;
    EXPECT_THROW(driver.method().ParseState(broken), Error);
    driver.Step(driver.active() == "path" ? 9 : 3);
  }
  EXPECT_THROW(Driver("path").method().ParseState(driver.state().Serialize()), Error);
}

// The targets of the trees can race, each with learning of its own.
TEST(Auto, TreesOfTwoTargetsRace) {
  Driver driver("path,sdtree,radiance");
  const std::vector<double> variances = {9, 6, 3};
  std::map<uint32_t, SdTreeOptions::Target> targets;
  while (!driver.settled()) {
    const Method::Active now = driver.now();
    if (now.candidate > 0)
      targets[now.candidate] = dynamic_cast<const SdTreeMethod&>(*now.method).options().tree.target;
    driver.Step(variances[now.candidate]);
  }
  EXPECT_EQ(driver.now().candidate, 2u);
  EXPECT_EQ(targets, (std::map<uint32_t, SdTreeOptions::Target>{{1, SdTreeOptions::Target::kSwitching},
                                                                {2, SdTreeOptions::Target::kRadiance}}));
  EXPECT_TRUE(driver.method().Explain(driver.state()).starts_with("radiance; path left out: radiance was "));
}

TEST(Auto, CandidatesAreNamedOnce) {
  for (const char* text : {"", "path,path", "path,tree", "path,", ",path", "focal,focal"})
    EXPECT_THROW(Driver{text}, Error) << text;
  EXPECT_EQ(Driver("sdtree").active(), "sdtree");
}

}  // namespace
}  // namespace lodestar
