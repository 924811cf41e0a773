#include "core/film/pixel_estimate.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace lodestar {
namespace {

Image Uniform(uint32_t width, uint32_t height, float value) {
  return {width, height, std::vector<Rgb>(size_t{width} * height, Rgb(value)),
          std::vector<float>(size_t{width} * height)};
}

TEST(PixelEstimate, AnEvenImageIsItsOwnEstimate) {
  for (const float value : {1e-12f, 0.5f, 1e12f}) {
    const PixelEstimate estimate = EstimatePixels(Uniform(7, 5, value));
    for (const float pixel : estimate.luminance) EXPECT_NEAR(pixel / value, 1, 1e-5);
  }
}

TEST(PixelEstimate, ABrightPatchSpreadsOverItsNeighbours) {
  Image image = Uniform(21, 21, 0);
  for (const uint32_t y : {9u, 10u, 11u})
    for (const uint32_t x : {9u, 10u, 11u}) image.pixels[y * 21 + x] = Rgb(49);  // mean 1
  const PixelEstimate estimate = EstimatePixels(image);
  EXPECT_LT(estimate.At(10, 10), 0.5f * 49);
  EXPECT_GT(estimate.At(13, 10), 1.0f);
  // Three 3x3 boxes reach three pixels far; beyond is the floor, a hundredth of the mean.
  EXPECT_FLOAT_EQ(estimate.At(15, 10), 0.01f);
  double inside = 0;
  for (uint32_t y = 6; y <= 14; ++y)
    for (uint32_t x = 6; x <= 14; ++x) inside += estimate.At(x, y);
  // All of its energy but a quarter of the corners, which have three neighbours of eight.
  EXPECT_NEAR(inside, 441 - 4 * 49 / 4.0, 0.2);  // and the floor around it
}

// Or what a few samples meet by chance would be expected where they met it.
TEST(PixelEstimate, ALonePixelCountsAsTwiceItsNeighbours) {
  for (const bool corner : {false, true}) {
    Image image = Uniform(21, 21, 1);
    const uint32_t at = corner ? 0 : 10;
    image.pixels[at * 21 + at] = Rgb(1e6f);
    Image twice = Uniform(21, 21, 1);
    twice.pixels[at * 21 + at] = Rgb(2);
    const PixelEstimate clamped = EstimatePixels(image), expected = EstimatePixels(twice);
    // The floor knows the whole image, which is bright.
    const float floor = clamped.At(20, 20);
    EXPECT_NEAR(floor, 1e4 / 441, 1);
    for (size_t i = 0; i < clamped.luminance.size(); ++i)
      EXPECT_EQ(clamped.luminance[i], std::max(floor, expected.luminance[i]));
  }
  Image dim = Uniform(21, 21, 1);
  dim.pixels[10 * 21 + 10] = Rgb(50);  // the floor lies below
  EXPECT_NEAR(EstimatePixels(dim).At(10, 10), 1 + 49.0f / 729, 1);
}

TEST(PixelEstimate, IsAboveZeroEverywhere) {
  Image half = Uniform(8, 8, 0);
  for (uint32_t i = 0; i < 8; ++i) half.pixels[i] = Rgb(1);
  for (const Image& image : {Uniform(4, 4, 0), Uniform(1, 1, 3), half})
    for (const float pixel : EstimatePixels(image).luminance) EXPECT_GT(pixel, 0);
}

TEST(PixelEstimate, RoundTripsAndRefusesWhatItDidNotWrite) {
  const PixelEstimate estimate = EstimatePixels(Uniform(3, 2, 0.25f));
  ByteWriter out;
  estimate.Write(out);
  const Bytes bytes = out.Take();
  ByteReader in(bytes, "estimate");
  EXPECT_EQ(PixelEstimate::Read(in).luminance, estimate.luminance);
  ByteWriter wrong;
  PixelEstimate other = estimate;
  other.luminance[1] = 0;
  other.Write(wrong);
  const Bytes wrong_bytes = wrong.Take();
  ByteReader wrong_in(wrong_bytes, "estimate");
  EXPECT_THROW(PixelEstimate::Read(wrong_in), Error);
  other = estimate;
  other.width = 4;
  ByteWriter wide;
  other.Write(wide);
  const Bytes wide_bytes = wide.Take();
  ByteReader wide_in(wide_bytes, "estimate");
  EXPECT_THROW(PixelEstimate::Read(wide_in), Error);
}

}  // namespace
}  // namespace lodestar
