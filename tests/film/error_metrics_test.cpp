#include "core/film/error_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/math/sampler.h"

namespace lodestar {
namespace {

Image Flat(uint32_t width, uint32_t height, Rgb value) {
  return {width, height, std::vector<Rgb>(size_t{width} * height, value), std::vector<float>(size_t{width} * height)};
}

TEST(ErrorMetrics, HandComputed) {
  Image reference = Flat(2, 1, Rgb(1, 2, 0)), image = reference;
  image.pixels[0] = Rgb(1.5f, 2, 0);  // one channel off by 1/2
  image.pixels[1] = Rgb(1, 2, -1);    // one by -1
  const ErrorMetrics m = Compare(image, reference);
  EXPECT_DOUBLE_EQ(m.mse, (0.25 + 1) / 6);
  EXPECT_DOUBLE_EQ(m.rmse, std::sqrt(1.25 / 6));
  EXPECT_DOUBLE_EQ(m.mae, 1.5 / 6);
  EXPECT_DOUBLE_EQ(m.relmse, (0.25 / 1.01 + 1 / 0.01) / 6);
  EXPECT_DOUBLE_EQ(m.relmse_trimmed, m.relmse);  // too few pixels to cut any
}

TEST(ErrorMetrics, EqualImagesHaveNoError) {
  const Image image = Flat(50, 50, Rgb(0.3f, 7, 1e12f));
  const ErrorMetrics m = Compare(image, image);
  EXPECT_EQ(m.rmse, 0);
  EXPECT_EQ(m.mae, 0);
  EXPECT_EQ(m.relmse, 0);
  EXPECT_EQ(m.relmse_trimmed, 0);
}

TEST(ErrorMetrics, TrimsTheWorstPerMille) {
  const Image reference = Flat(100, 20, Rgb(1));  // 2000 pixels: two are cut
  Image image = reference;
  for (Rgb& pixel : image.pixels) pixel = Rgb(1.1f);
  image.pixels[3] = Rgb(1000);
  image.pixels[1999] = Rgb(500);
  const double usual = 0.01 / 1.01;
  const ErrorMetrics m = Compare(image, reference);
  EXPECT_NEAR(m.relmse_trimmed, usual, 1e-7);
  EXPECT_NEAR(m.relmse, (1998 * usual + (999.0 * 999 + 499.0 * 499) / 1.01) / 2000, 1e-3);
  image.pixels[1000] = Rgb(2);  // a third outlier stays in
  EXPECT_NEAR(Compare(image, reference).relmse_trimmed, (1997 * usual + 1 / 1.01) / 1998, 1e-6);
}

TEST(ErrorMetrics, RefusesWhatCannotBeCompared) {
  const Image reference = Flat(4, 4, Rgb(1));
  EXPECT_THROW(Compare(Flat(4, 5, Rgb(1)), reference), Error);
  EXPECT_THROW(RelativeLuminanceError(Flat(16, 1, Rgb(1)), reference), Error);
  Image nan = reference;
  nan.pixels[6].b = std::numeric_limits<float>::quiet_NaN();
  try {
    Compare(reference, nan);
    FAIL() << "a NaN passed";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
    EXPECT_NE(std::string(error.what()).find("reference has a pixel that is not finite at x 2, y 1"), std::string::npos)
        << error.what();
  }
}

TEST(EstimatedError, HandComputed) {
  Image image = Flat(2, 2, Rgb(2));
  image.variance = {0.1f, 0.2f, 0.3f, 0.4f};
  const EstimatedError error = EstimateError(image);
  EXPECT_NEAR(error.relmse, 0.25 / 4.01, 1e-6);
  EXPECT_DOUBLE_EQ(error.relmse, error.relmse_trimmed);
}

TEST(EstimatedError, BlackIsZeroAndNoVarianceIsUnknown) {
  EXPECT_EQ(EstimateError(Flat(3, 3, Rgb(0))).relmse_trimmed, 0);
  Image reference = Flat(3, 3, Rgb(1));
  reference.variance.clear();
  EXPECT_EQ(EstimateError(reference).relmse, std::numeric_limits<double>::infinity());
  EXPECT_EQ(EstimateError(Image{}).relmse, std::numeric_limits<double>::infinity());
}

// One pixel in 2304 has met light: it is what there is, and no outlier.
TEST(EstimatedError, WhatHoldsTheLightIsNotTrimmed) {
  Image image = Flat(48, 48, Rgb(0));
  image.variance.assign(image.size(), 0);
  image.pixels[1000] = Rgb(100);
  image.variance[1000] = 1e4f;  // one sample of 16, near enough
  const double mean = 100.0 / (48 * 48);
  EXPECT_NEAR(EstimateError(image).relmse_trimmed, 1e4 / (mean * mean + 0.01) / (48 * 48), 1);
  // Beside the light of all others it is an outlier.
  for (Rgb& pixel : image.pixels) pixel += Rgb(1);
  EXPECT_EQ(EstimateError(image).relmse_trimmed, 0);
}

// Noise of a known kind over a gradient: `passes` samples of mean 1 with a chance `hit` of being lit.
struct Noisy {
  Image image, reference;
};
Noisy Render(float hit, uint32_t passes) {
  const TileGrid grid(96, 96);
  Film film(grid);
  Noisy result;
  result.reference = Flat(96, 96, Rgb(0));
  for (uint32_t t = 0; t < grid.tile_count(); ++t) {
    const TileRect rect = grid.Rect(t);
    FilmTile tile{t, std::vector<PixelSum>(rect.pixels())};
    for (uint32_t i = 0; i < rect.pixels(); ++i) {
      const uint32_t x = rect.x0 + i % rect.width(), y = rect.y0 + i / rect.width();
      const float mean = 0.2f + 0.05f * static_cast<float>(x);
      result.reference.pixels[y * 96 + x] = Rgb(mean);
      for (uint32_t pass = 0; pass < passes; ++pass) {
        // Beyond the stratified dimensions: independent samples, whose variance the film's moments tell without bias.
        Sampler sampler(1, x, y, pass);
        sampler.StartAt(Sampler::kSobolPairs);
        tile.pixels[i].Add(Rgb(sampler.Next2D().x < hit ? mean / hit : 0));
      }
    }
    film.Add(grid, tile);
  }
  film.AddPasses(passes);
  result.image = film.Develop();
  return result;
}

TEST(EstimatedError, AgreesWithTheTrueErrorOfKnownNoise) {
  for (const float hit : {0.5f, 0.1f}) {
    for (const uint32_t passes : {32u, 256u}) {
      const Noisy noisy = Render(hit, passes);
      const double estimated = EstimateError(noisy.image).relmse, truth = Compare(noisy.image, noisy.reference).relmse;
      EXPECT_NEAR(estimated / truth, 1, 0.06) << hit << " " << passes << ": " << estimated << " " << truth;
      const double expected = (1 / hit - 1) / passes;  // variance over the squared mean
      EXPECT_NEAR(estimated / expected, 1, 0.08) << hit << " " << passes;
    }
  }
}

TEST(EstimatedError, SeesErrorsAboveOne) {
  // One sample in 200 is lit: nine pixels in ten of 20 passes stay black, and the relative variance of the mean is 10.
  // The variance over the pixel's own luminance could never exceed 1.
  const Noisy noisy = Render(0.005f, 20);
  const double truth = Compare(noisy.image, noisy.reference).relmse;
  EXPECT_GT(truth, 7);
  EXPECT_GT(EstimateError(noisy.image).relmse, 2);
}

TEST(RelativeLuminanceError, IsSigned) {
  const std::vector<float> error = RelativeLuminanceError(Flat(1, 1, Rgb(1.5f)), Flat(1, 1, Rgb(1)));
  EXPECT_NEAR(error[0], 0.5 / 1.01, 1e-6);
  EXPECT_NEAR(RelativeLuminanceError(Flat(1, 1, Rgb(0)), Flat(1, 1, Rgb(1)))[0], -1 / 1.01, 1e-6);
  EXPECT_EQ(RelativeLuminanceError(Flat(1, 1, Rgb(0)), Flat(1, 1, Rgb(0)))[0], 0);
}

TEST(FalseColour, DivergesFromABrightMiddle) {
  const auto bytes = FalseColour({0, -1, 1, -7, 7, std::numeric_limits<float>::quiet_NaN(), -0.5f, 0.5f});
  ASSERT_EQ(bytes.size(), 24u);
  const auto at = [&](int i, int c) { return static_cast<int>(bytes[static_cast<size_t>(i * 3 + c)]); };
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(at(0, c), 235);       // nearly white
    EXPECT_EQ(at(3, c), at(1, c));  // clamped at the ends
    EXPECT_EQ(at(4, c), at(2, c));
    EXPECT_EQ(at(5, c), 0);  // NaN is not on the scale
  }
  EXPECT_GT(at(1, 2), at(1, 0) + 60);  // blue below
  EXPECT_GT(at(2, 0), at(2, 2) + 60);  // orange above
  EXPECT_GT(at(6, 2), at(6, 0) + 30);
  EXPECT_GT(at(7, 0), at(7, 2) + 30);
}

TEST(FalseColour, LightnessFallsAlikeOnBothSides) {
  // CIE luminance of the two ends of equal error, from the sRGB bytes.
  const auto luminance = [](const std::vector<uint8_t>& bytes) {
    double y = 0;
    const double weights[] = {0.2126, 0.7152, 0.0722};
    for (int c = 0; c < 3; ++c) {
      const double v = bytes[static_cast<size_t>(c)] / 255.0;
      y += weights[c] * (v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return y;
  };
  double last = 2;
  for (float t = 0; t <= 1; t += 0.125f) {
    const double below = luminance(FalseColour({-t})), above = luminance(FalseColour({t}));
    EXPECT_NEAR(below, above, 0.06) << t;
    EXPECT_LT(above, last);
    last = above;
  }
}

}  // namespace
}  // namespace lodestar
