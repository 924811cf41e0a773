// The colours of `inspect --guide --range`, pixel by pixel: logarithmic between the two densities, and beyond them
// those of the ends.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "client/guide_canvas.h"
#include "client/outputs.h"
#include "core/film/oklab.h"
#include "core/guiding/focal_projection.h"
#include "core/learning/guide_file.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

constexpr int kAxis = 1;  // of focal-max-y.png

// The picture along kAxis: the pixels of the values, without title and legend.
std::vector<Rgb> DrawnIn(const std::filesystem::path& folder, const std::string& state, const FloatGrid& grid,
                         const LogScale& scale) {
  std::ostringstream range;
  range.precision(9);  // enough to read the same floats
  range << scale.low << "," << scale.high;
  const Ran ran = RunLodestar({"inspect", "--guide", state, "-o", folder, "--range", range.str()});
  EXPECT_EQ(ran.code, 0) << ran.err;
  const Image image = ReadImageFile(folder / "focal-max-y.png");
  constexpr uint32_t kMargin = 12, kTop = 32;  // as DrawPicture() has them
  std::vector<Rgb> pixels;
  EXPECT_EQ(image.width, grid.width + 2 * kMargin);
  EXPECT_GT(image.height, grid.height + kTop);
  if (testing::Test::HasFailure()) return std::vector<Rgb>(grid.values.size());
  for (uint32_t y = 0; y < grid.height; ++y) {
    for (uint32_t x = 0; x < grid.width; ++x)
      pixels.push_back(image.pixels[size_t{kTop + y} * image.width + kMargin + x]);
  }
  return pixels;
}

bool HasColour(Rgb pixel, Colour colour) {
  bool same = true;
  for (int c = 0; c < 3; ++c)
    same &= std::fabs(pixel[c] - SrgbToLinear(static_cast<float>(colour[static_cast<size_t>(c)]) / 255)) < 1e-5f;
  return same;
}

TEST(InspectRange, DensitiesBeyondTheEndsHaveTheColoursOfTheEnds) {
  const TemporaryFolder folder;
  const std::string state = folder / "a.lguide";
  const Ran ran = RunLodestar({"render", folder.Write("tiny.pbrt", kTinyScene), "--method", "focal", "--resolution",
                               "32x24", "--spp", "63", "--state", state, "-o", folder / "a.exr"},
                              {"LODESTAR_PLOT=/nonexistent"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto field = FocalField::Parse(GuideFile::Read(state).state);
  const FloatGrid grid = ProjectAlong(*field, 0, FocalProjection::kMaximum, kAxis, 512);
  float least = kInfinity, greatest = 0;
  for (const float value : grid.values) {
    if (value > 0) least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  ASSERT_LT(least, 0.5f * greatest);

  const LogScale narrow{std::pow(least, 0.75f) * std::pow(greatest, 0.25f),
                        std::pow(least, 0.25f) * std::pow(greatest, 0.75f)},
      wide{least / 10, greatest * 10};
  const std::vector<Rgb> in_narrow = DrawnIn(folder / "narrow", state, grid, narrow),
                         in_wide = DrawnIn(folder / "wide", state, grid, wide);
  EXPECT_FALSE(in_narrow == in_wide);
  const Colour lowest = SequentialColour(0), highest = SequentialColour(1);
  int below = 0, above = 0, wrong = 0;
  for (size_t i = 0; i < grid.values.size(); ++i) {
    const float value = grid.values[i];
    if (!(value > 0)) continue;
    below += value < narrow.low;
    above += value > narrow.high;
    const Colour expected = value < narrow.low    ? lowest
                            : value > narrow.high ? highest
                                                  : SequentialColour(narrow.Position(value));
    wrong += !HasColour(in_narrow[i], expected);
    // No density is at the ends of a range that holds them all.
    wrong += HasColour(in_wide[i], lowest) || HasColour(in_wide[i], highest) ||
             !HasColour(in_wide[i], SequentialColour(wide.Position(value)));
  }
  EXPECT_GT(below, 0);
  EXPECT_GT(above, 0);
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace lodestar
