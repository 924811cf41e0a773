// Colours, scales and legends of pictures of values.
#include "client/guide_canvas.h"

#include <gtest/gtest.h>

#include "client/outputs.h"
#include "core/film/oklab.h"
#include "core/math/srgb.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

float LinearLuminance(Colour c) {
  const auto linear = [&](size_t i) { return SrgbToLinear(static_cast<float>(c[i]) / 255); };
  return Luminance({linear(0), linear(1), linear(2)});
}

TEST(SequentialColour, GetsLighterWithoutJumps) {
  float last = -1;
  for (int i = 0; i <= 200; ++i) {
    const Colour c = SequentialColour(static_cast<float>(i) / 200),
                 next = SequentialColour(static_cast<float>(i + 1) / 200);
    EXPECT_GT(LinearLuminance(c), last) << i;
    last = LinearLuminance(c);
    for (size_t k = 0; k < 3; ++k) EXPECT_LE(std::abs(int{c[k]} - int{next[k]}), 8) << i;
  }
  EXPECT_EQ(SequentialColour(-1), SequentialColour(0));
  EXPECT_EQ(SequentialColour(2), SequentialColour(1));
}

TEST(LogScale, SpansThePositiveValues) {
  FloatGrid grid(2, 2);
  grid.values = {0, 0.1f, 1, 10};
  const LogScale scale = LogScale::Of(grid);
  EXPECT_EQ(scale.low, 0.1f);
  EXPECT_EQ(scale.high, 10.0f);
  EXPECT_NEAR(scale.Position(1), 0.5f, 1e-5f);
  EXPECT_EQ(scale.Position(0.01f), 0);
  EXPECT_EQ(scale.Position(99), 1);
  grid.values = {1e-12f, 1, 1, 1};  // five powers of ten at most
  EXPECT_NEAR(LogScale::Of(grid).low, 1e-5f, 1e-9f);
  grid.values = {3, 3, 3, 3};  // a constant is in the middle
  EXPECT_NEAR(LogScale::Of(grid).Position(3), 0.5f, 1e-5f);
  grid.values = {0, 0, 0, 0};
  EXPECT_LT(LogScale::Of(grid).low, LogScale::Of(grid).high);
}

// What a picture of 3 x 1 values looks like in its file: blocks of 128 pixels in the values' colours under the title.
TEST(Picture, ValuesHaveTheirColours) {
  TemporaryFolder folder;
  FloatGrid grid(3, 1);
  grid.values = {0, 1, 100};
  PictureStyle style;
  style.title = "title";
  const Canvas canvas = DrawPicture(grid, style);
  canvas.WritePng(folder / "a.png");
  const Image image = ReadImageFile(folder / "a.png");
  ASSERT_EQ(image.width, canvas.width());
  ASSERT_EQ(image.height, canvas.height());
  const auto at = [&](uint32_t x) { return image.pixels[size_t{90} * image.width + x]; };
  const auto expect = [&](uint32_t x, Colour colour) {
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(at(x)[c], SrgbToLinear(static_cast<float>(colour[static_cast<size_t>(c)]) / 255), 1e-5f) << x;
  };
  expect(12 + 64, {0, 0, 0});
  expect(12 + 128 + 64, SequentialColour(0));
  expect(12 + 256 + 64, SequentialColour(1));
  expect(4, {250, 250, 250});
  size_t ink = 0;  // of the title
  for (uint32_t y = 0; y < 30; ++y) {
    for (uint32_t x = 0; x < 100; ++x) ink += image.pixels[size_t{y} * image.width + x].g < 0.1f;
  }
  EXPECT_GT(ink, 100u);
}

}  // namespace
}  // namespace lodestar
