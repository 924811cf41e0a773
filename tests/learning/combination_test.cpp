#include "core/learning/combination.h"

#include <gtest/gtest.h>

#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

constexpr auto kInverse = Method::Combination::kInverseVariance, kDiscard = Method::Combination::kDiscard,
               kAutomatic = Method::Combination::kAutomatic;

// A 4x4 film of `passes` passes of mean 1, half of them 1 + spread and half 1 - spread.
IterationFilm FilmOf(uint32_t iteration, uint32_t passes, float spread, float mean = 1) {
  const TileGrid grid(4, 4);
  IterationFilm result{iteration, Film(grid)};
  FilmTile tile{0, std::vector<PixelSum>(16)};
  for (PixelSum& pixel : tile.pixels) {
    for (uint32_t i = 0; i < passes; ++i) pixel.Add(Rgb(mean + (passes == 1 ? 0 : i % 2 == 0 ? spread : -spread)));
  }
  result.film.Add(grid, tile);
  result.film.AddPasses(passes);
  return result;
}

TEST(Combination, DiscardTakesTheLongestAlone) {
  std::vector<IterationFilm> films;
  films.push_back(FilmOf(4, 16, 1));
  films.push_back(FilmOf(5, 8, 1));
  EXPECT_EQ(Combine(films, kDiscard).weights, (std::vector<double>{1, 0}));  // the new one has just begun
  films[1] = FilmOf(5, 16, 1);
  EXPECT_EQ(Combine(films, kDiscard).weights, (std::vector<double>{0, 1}));
  EXPECT_EQ(Combine(films, kAutomatic).weights, (std::vector<double>{0, 1}));
  EXPECT_EQ(Combine(films, kDiscard).passes, 16u);
}

TEST(Combination, WeightsAreInverseVariances) {
  std::vector<IterationFilm> films;
  films.push_back(FilmOf(0, 8, 2));   // variance of the mean 4/7
  films.push_back(FilmOf(1, 16, 1));  // 1/15
  const auto [w, image, passes] = Combine(films, kInverse);
  EXPECT_NEAR(w[1] / w[0], (4.0 / 7) * 15, 1e-4);
  EXPECT_NEAR(w[0] + w[1], 1, 1e-12);
  EXPECT_EQ(passes, 24u);
  EXPECT_NEAR(image.pixels[3].g, 1, 1e-6);
  EXPECT_NEAR(image.variance[3], w[0] * w[0] * 4 / 7 + w[1] * w[1] / 15, 1e-6);
  EXPECT_LT(image.variance[3], 1.0 / 15);  // better than the better of the two
}

// Two films of equal mean pixel variance, one noisy where the picture is bright, the other where it is dark.
TEST(Combination, NoiseInTheDarkCountsMore) {
  const TileGrid grid(4, 4);
  std::vector<IterationFilm> films;
  for (const bool noisy_dark : {false, true}) {
    films.push_back({noisy_dark ? 1u : 0u, Film(grid), noisy_dark ? 1u : 0u});
    FilmTile tile{0, std::vector<PixelSum>(16)};
    for (size_t p = 0; p < 16; ++p) {
      const bool dark = p % 4 < 2;
      const float mean = dark ? 1 : 100, spread = dark == noisy_dark ? 0.5f : 0.0f;
      for (uint32_t i = 0; i < 8; ++i) tile.pixels[p].Add(Rgb(mean + (i % 2 == 0 ? spread : -spread)));
    }
    films.back().film.Add(grid, tile);
    films.back().film.AddPasses(8);
  }
  const std::vector<double> w = Combine(films, kInverse).weights;
  EXPECT_GT(w[0], 2 * w[1]);  // by the absolute variance they would count alike
}

// An iteration of few passes that has not met what the next one shows: both are as noisy as the two together, a pass.
TEST(Combination, OfOneCandidateNoFilmIsBetterThanALaterOne) {
  const auto weights = [](float first, float second, uint32_t candidate) {
    std::vector<IterationFilm> films = {FilmOf(0, 2, 2), FilmOf(1, 4, first), FilmOf(2, 12, second)};
    films[2].candidate = candidate;
    return Combine(films, kInverse).weights;
  };
  const std::vector<double> missed = weights(0.1f, 1, 0);
  EXPECT_NEAR(missed[1] / missed[2], 4.0 / 12, 1e-9);
  EXPECT_LT(missed[0] / missed[1], 0.5 * 2 / 4);  // who is known to be noisier stays so
  const std::vector<double> learned = weights(1, 0.5f, 0);
  EXPECT_NEAR(learned[1] / learned[2], (0.25 / 11) / (1.0 / 3), 1e-4);
  EXPECT_GT(weights(0.1f, 1, 1)[1], 0.9);  // of another candidate nothing follows
}

TEST(Combination, ZeroVarianceDoesNotOwnTheImage) {
  std::vector<IterationFilm> films;
  films.push_back(FilmOf(0, 2, 0, 0));  // two black passes by chance
  films.push_back(FilmOf(1, 30, 1));
  const std::vector<double> w = Combine(films, kInverse).weights;
  EXPECT_NEAR(w[0], 2.0 / 32, 1e-9);  // as good per pass as the other, not infinitely good
  films.push_back(FilmOf(2, 30, 0.1f));
  const std::vector<double> three = Combine(films, kInverse).weights;
  EXPECT_NEAR(three[0] / three[1], 2.0 / 30, 1e-9);  // of two others, the worse
}

// All of its light in the few pixels that reports leave out: without them it would be free of noise.
TEST(Combination, OutliersThatHoldTheLightCount) {
  const TileGrid grid(48, 48);
  std::vector<IterationFilm> films = {{0, Film(grid)}, {1, Film(grid)}};
  for (uint32_t unit = 0; unit < grid.tile_count(); ++unit) {
    FilmTile tile{unit, std::vector<PixelSum>(grid.Rect(unit).pixels())};
    if (unit == 0) tile.pixels[3].Add(Rgb(20000));
    films[0].film.Add(grid, tile);
    for (PixelSum& pixel : tile.pixels) {
      pixel = {};
      for (int i = 0; i < 10; ++i) pixel.Add(Rgb(i % 2 == 0 ? 2.0f : 0.0f));
    }
    films[1].film.Add(grid, tile);
  }
  for (IterationFilm& film : films) film.film.AddPasses(10);
  EXPECT_LT(Combine(films, kInverse).weights[0], 0.1);
}

// Two films of the same samples, one in 4000 of them rare and bright, of few passes and of many. All that is rare in
// the first lies in a thousandth of its pixels, and enters the image.
TEST(Combination, RareSamplesOfFewPassesCount) {
  const TileGrid grid(128, 128);
  test::Random random(3);
  double share = 0;
  constexpr int kTrials = 10;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<IterationFilm> films;
    for (const uint32_t passes : {2u, 30u}) {
      films.push_back({0, Film(grid), static_cast<uint32_t>(films.size())});
      for (uint32_t t = 0; t < grid.tile_count(); ++t) {
        FilmTile tile{t, std::vector<PixelSum>(grid.Rect(t).pixels())};
        for (PixelSum& pixel : tile.pixels)
          for (uint32_t i = 0; i < passes; ++i)
            pixel.Add(Rgb(0.9f + 0.2f * random.Next1D() + (random.Next1D() < 1 / 4000.0f ? 100.0f : 0.0f)));
        films.back().film.Add(grid, tile);
      }
      films.back().film.AddPasses(passes);
    }
    share += Combine(films, kInverse).weights[0] / kTrials;
  }
  EXPECT_NEAR(share, 2.0 / 32, 0.03);  // 0.9 where a thousandth of the pixels of either is left out
}

TEST(Combination, ABlackSceneIsWeightedByPasses) {
  std::vector<IterationFilm> films;
  films.push_back(FilmOf(0, 4, 0, 0));
  films.push_back(FilmOf(1, 12, 0, 0));
  EXPECT_EQ(Combine(films, kInverse).weights, (std::vector<double>{0.25, 0.75}));
  const Image image = Combine(films, kInverse).image;
  EXPECT_EQ(image.pixels[0], Rgb(0));
  EXPECT_EQ(image.variance[0], 0);
}

// `passes` of independent samples, uniform in 1 +- spread, times `scale`.
IterationFilm NoisyFilm(uint32_t iteration, uint32_t passes, float spread, float scale = 1) {
  const TileGrid grid(64, 64);
  IterationFilm result{iteration, Film(grid)};
  for (uint32_t unit = 0; unit < grid.tile_count(); ++unit) {
    FilmTile tile{unit, std::vector<PixelSum>(grid.Rect(unit).pixels())};
    Sampler sampler(iteration, unit, 0, 0);
    sampler.StartAt(Sampler::kSobolPairs);  // independent from there on
    for (PixelSum& pixel : tile.pixels) {
      for (uint32_t i = 0; i < passes; ++i) pixel.Add(Rgb(scale * (1 + spread * (2 * sampler.Next2D().x - 1))));
    }
    result.film.Add(grid, tile);
  }
  result.film.AddPasses(passes);
  return result;
}

TEST(Combination, OnePassIsMeasuredAgainstTheOthers) {
  std::vector<IterationFilm> films;
  films.push_back(NoisyFilm(0, 1, 0.5f));
  EXPECT_EQ(Combine(films, kInverse).weights, (std::vector<double>{1}));
  EXPECT_EQ(Combine(films, kInverse).image.variance[0], 0);  // nothing to measure it against
  films.push_back(NoisyFilm(1, 1, 0.5f));
  EXPECT_NEAR(Combine(films, kInverse).weights[0], 0.5, 1e-6);  // what lies between them is all that is known of both
  films.push_back(NoisyFilm(2, 16, 0.5f));
  EXPECT_NEAR(Combine(films, kInverse).weights[0], 1.0 / 18, 0.1 / 18);

  // Three times the spread: nine times the variance, less what the others' passes take from it, a part in 17.
  films[0] = NoisyFilm(0, 1, 1.5f);
  films[1] = NoisyFilm(1, 16, 0.5f);
  films.pop_back();
  const auto [weights, image, passes] = Combine(films, kInverse);
  EXPECT_NEAR(weights[1] / weights[0], 16 * (9 * 16 + 1) / 17.0, 0.1 * 16 * 9);
  EXPECT_EQ(passes, 17u);
  // The image's own variance, which reports go by, counts the single pass's too.
  double estimated = 0, actual = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    estimated += image.variance[i] / static_cast<double>(image.size());
    actual += std::pow(Luminance(image.pixels[i]) - 1, 2) / static_cast<double>(image.size());
  }
  EXPECT_NEAR(estimated / actual, 1, 0.1);
}

TEST(Combination, TheUnitOfLightDoesNotMatter) {
  const auto weights = [](float scale) {
    std::vector<IterationFilm> films;
    films.push_back(NoisyFilm(0, 1, 1.5f, scale));
    films.push_back(NoisyFilm(1, 4, 1.0f, scale));
    films.push_back(NoisyFilm(2, 8, 0.5f, scale));
    return Combine(films, kInverse).weights;
  };
  for (const float scale : {1e-6f, 1e6f}) {
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(weights(scale)[i], weights(1)[i], 1e-4) << scale;
  }
}

// Iterations of two candidates, as the loop goes through them: what becomes one film weighs as it did apart, so the
// image is that of all films, and there are never more than three of a candidate.
TEST(Combination, NoFilmIsLostAndFewAreKept) {
  struct Step {
    uint32_t candidate, passes;
    float spread;
  };
  const std::vector<Step> steps = {{0, 4, 1.5f},  {1, 1, 2},     {1, 2, 1.8f}, {1, 4, 1.2f}, {1, 8, 1},
                                   {1, 16, 0.9f}, {1, 16, 0.8f}, {0, 8, 1.5f}, {1, 8, 0.5f}, {1, 8, 0.4f}};
  std::vector<IterationFilm> all, kept;
  uint64_t passes = 0;
  for (uint32_t i = 0; i < steps.size(); ++i) {
    if (!kept.empty()) MakeRoom(&kept, kInverse, Combine(kept, kInverse).weights);
    IterationFilm film = NoisyFilm(i, steps[i].passes, steps[i].spread);
    film.candidate = steps[i].candidate;
    film.rays = film.vertices = steps[i].passes;
    passes += steps[i].passes;
    all.push_back(film);
    kept.push_back(film);
    EXPECT_LE(std::ranges::count(kept, 1u, &IterationFilm::candidate), MostFilms(kInverse));
  }
  ASSERT_EQ(kept.size(), 6u);
  const uint64_t pooled = 1 + 2 + 4 + 8 + 16;
  EXPECT_EQ(kept[1].film.passes(), pooled);
  EXPECT_EQ(kept[1].rays, pooled);
  EXPECT_EQ(kept[1].vertices, pooled);
  EXPECT_TRUE(std::ranges::is_sorted(kept, {}, &IterationFilm::iteration));

  const auto few = Combine(kept, kInverse), many = Combine(all, kInverse);
  EXPECT_EQ(few.passes, passes);
  double weight = 0;
  for (size_t i = 1; i <= 5; ++i) weight += many.weights[i];
  EXPECT_NEAR(few.weights[1] / weight, 1, 0.02);
  for (size_t p = 0; p < few.image.size(); ++p) {
    EXPECT_NEAR(few.image.pixels[p].g, many.image.pixels[p].g, 0.003);
    EXPECT_NEAR(few.image.variance[p] / many.image.variance[p], 1, 0.02);
  }
}

TEST(Combination, OnlyTheLastFilmIsKeptWhereOthersAreDiscarded) {
  for (const auto combination : {kDiscard, kAutomatic}) {
    std::vector<IterationFilm> films = {FilmOf(3, 8, 1), FilmOf(4, 16, 1)};
    MakeRoom(&films, combination, Combine(films, combination).weights);
    ASSERT_EQ(films.size(), 1u);
    EXPECT_EQ(films.size() + 1, MostFilms(combination));
    EXPECT_EQ(films[0].iteration, 4u);
  }
}

TEST(Combination, NothingRenderedIsBlack) {
  std::vector<IterationFilm> films;
  films.push_back({0, Film(TileGrid(4, 4))});
  for (const auto combination : {kInverse, kDiscard}) {
    const auto [w, image, passes] = Combine(films, combination);
    EXPECT_EQ(w, (std::vector<double>{0}));
    EXPECT_EQ(image.pixels[0], Rgb(0));
    EXPECT_EQ(passes, 0u);
  }
}

}  // namespace
}  // namespace lodestar
