#include "core/math/primaries.h"

#include <gtest/gtest.h>

namespace lodestar {
namespace {

// SMPTE ST 2065-1.
constexpr Chromaticities kAces{0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f};

void ExpectColour(Rgb actual, Rgb expected, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "component " << c;
}

TEST(Primaries, Rec709IsItself) {
  for (const WhitePoint white : {WhitePoint::kKept, WhitePoint::kAdapted})
    ExpectColour((*ToRec709(kRec709, white))({0.2f, 3, 0.7f}), {0.2f, 3, 0.7f}, 1e-6f);
}

// Against the matrix that is printed for ACES2065-1 to linear Rec. 709 with Bradford's adaptation (five decimals).
TEST(Primaries, AcesAdapted) {
  const auto convert = *ToRec709(kAces, WhitePoint::kAdapted);
  ExpectColour(convert(Rgb(1)), Rgb(1), 1e-4f);
  ExpectColour(
      convert({0.3f, 0.36f, 0.5f}),
      {2.52169f * 0.3f - 1.13413f * 0.36f - 0.38756f * 0.5f, -0.27648f * 0.3f + 1.37272f * 0.36f - 0.09624f * 0.5f,
       -0.01538f * 0.3f - 0.15298f * 0.36f + 1.16835f * 0.5f},
      1e-4f);
}

// Light of the space's white keeps its xy: that of ACES, near D60, is warmer than D65.
TEST(Primaries, AcesKept) {
  const Rgb white = (*ToRec709(kAces, WhitePoint::kKept))(Rgb(1));
  // Of xy = (0.32168, 0.33767), by the matrix of IEC 61966-2-1.
  const float x = 0.32168f / 0.33767f, z = (1 - 0.32168f - 0.33767f) / 0.33767f;
  ExpectColour(white,
               {3.2404542f * x - 1.5371385f - 0.4985314f * z, -0.9692660f * x + 1.8760108f + 0.0415560f * z,
                0.0556434f * x - 0.2040259f + 1.0572252f * z},
               1e-3f);
  EXPECT_GT(white.r, white.b + 0.05f);
}

TEST(Primaries, OutsideOfTheGamutIsZero) {
  EXPECT_EQ((*ToRec709(kAces, WhitePoint::kAdapted))({0, 1, 0}).r, 0);
}

TEST(Primaries, NoColourSpace) {
  EXPECT_FALSE(ToRec709({0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 0.3f, 0.3f}, WhitePoint::kKept));  // in a line
  Chromaticities dark = kRec709;
  dark[7] = 0;
  EXPECT_FALSE(ToRec709(dark, WhitePoint::kAdapted));
}

}  // namespace
}  // namespace lodestar
