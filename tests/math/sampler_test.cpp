// The sampler: a pure function, uniform, a (0, 4, 2)-net in each block of sixteen passes, independent between pixels,
// blocks and dimensions.
#include "core/math/sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

constexpr uint32_t kPairs = Sampler::kSobolPairs + 3;  // some hashed ones too
const double kLevel = SidakLevel(0.01, 60);

std::vector<Vec2> Block(uint64_t seed, uint32_t x, uint32_t y, uint32_t block, uint32_t pair) {
  std::vector<Vec2> points;
  for (uint32_t pass = 0; pass < Sampler::kBlockPasses; ++pass) {
    Sampler s(seed, x, y, block * Sampler::kBlockPasses + pass);
    s.StartAt(pair);
    points.push_back(s.Next2D());
  }
  return points;
}

// Every elementary interval of area 1/16 (16x1, 8x2, 4x4, 2x8, 1x16) holds exactly one of the sixteen points.
bool IsNet(const std::vector<Vec2>& points) {
  for (int log_x = 0; log_x <= 4; ++log_x) {
    const int nx = 1 << log_x, ny = 16 >> log_x;
    std::array<int, 16> count{};
    for (const Vec2 p : points) ++count[static_cast<int>(p.x * nx) * ny + static_cast<int>(p.y * ny)];
    for (const int c : count) {
      if (c != 1) return false;
    }
  }
  return true;
}

TEST(Sampler, IsPure) {
  for (uint32_t pair = 0; pair < kPairs; ++pair) {
    Sampler a(7, 3, 4, 21), b(7, 3, 4, 21);
    for (uint32_t i = 0; i < pair; ++i) a.Next2D();
    b.StartAt(pair);
    EXPECT_EQ(a.Next2D(), b.Next2D()) << pair;
  }
  EXPECT_EQ(Sampler(7, 3, 4, 21).Next2D().x, Sampler(7, 3, 4, 21).Next2D().x);
}

TEST(Sampler, ChangesWithEveryKey) {
  const Vec2 base = Sampler(7, 3, 4, 21).Next2D();
  EXPECT_NE(base, Sampler(8, 3, 4, 21).Next2D());
  EXPECT_NE(base, Sampler(7, 4, 4, 21).Next2D());
  EXPECT_NE(base, Sampler(7, 3, 5, 21).Next2D());
  EXPECT_NE(base, Sampler(7, 4, 3, 21).Next2D());
  EXPECT_NE(base, Sampler(7, 3, 4, 22).Next2D());
  EXPECT_NE(base, Sampler(7, 3, 4, 37).Next2D());
}

TEST(Sampler, BlocksAreNets) {
  for (uint32_t pair = 0; pair < Sampler::kSobolPairs; ++pair) {
    for (uint32_t pixel = 0; pixel < 50; ++pixel) {
      for (const uint32_t block : {0u, 1u, 1000000u}) {
        EXPECT_TRUE(IsNet(Block(11, pixel * 17, pixel, block, pair))) << pair << ' ' << pixel << ' ' << block;
      }
    }
  }
  EXPECT_FALSE(IsNet(Block(11, 0, 0, 0, Sampler::kSobolPairs)));  // the hashed ones are not: the check can fail
}

TEST(Sampler, IsUniformInEveryDimension) {
  for (uint32_t pair = 0; pair < kPairs; ++pair) {
    std::vector<float> x, y;
    for (uint32_t pixel = 0; pixel < 20000; ++pixel) {
      // One pass a pixel: independent, unlike the passes of a block.
      Sampler s(5, pixel % 200, pixel / 200, pixel % 40);
      s.StartAt(pair);
      const Vec2 u = s.Next2D();
      x.push_back(u.x), y.push_back(u.y);
    }
    const TestResult rx = ChiSquareUniform(x, 100, kLevel), ry = ChiSquareUniform(y, 100, kLevel);
    EXPECT_TRUE(rx.accepted) << pair << ": " << rx.message;
    EXPECT_TRUE(ry.accepted) << pair << ": " << ry.message;
  }
}

// Pairs of numbers on a 16 x 16 grid.
TestResult Independence(const std::vector<Vec2>& pairs) {
  std::vector<double> observed(256, 0.0), expected(256, static_cast<double>(pairs.size()) / 256);
  for (const Vec2 p : pairs) ++observed[static_cast<int>(p.x * 16) * 16 + static_cast<int>(p.y * 16)];
  return ChiSquareTest(observed, expected, kLevel);
}

TEST(Sampler, NeighbouringPixelsPassesBlocksAndSeedsAreIndependent) {
  const auto value = [](uint64_t seed, uint32_t x, uint32_t y, uint32_t pass, uint32_t pair) {
    Sampler s(seed, x, y, pass);
    s.StartAt(pair);
    return s.Next2D().x;
  };
  for (const uint32_t pair : {0u, 1u, 5u, 6u, 9u}) {
    std::vector<Vec2> right, below, block, dimension, seed, within;
    for (uint32_t i = 0; i < 20000; ++i) {
      const uint32_t x = 2 * (i % 200), y = 2 * (i / 200);
      const float v = value(1, x, y, 3, pair);
      right.push_back({v, value(1, x + 1, y, 3, pair)});
      below.push_back({v, value(1, x, y + 1, 3, pair)});
      block.push_back({v, value(1, x, y, 3 + Sampler::kBlockPasses, pair)});
      dimension.push_back({v, value(1, x, y, 3, pair + 1)});
      seed.push_back({v, value(2, x, y, 3, pair)});
      Sampler s(1, x, y, 3);
      s.StartAt(pair);
      within.push_back(s.Next2D());
    }
    for (const auto* pairs : {&right, &below, &block, &dimension, &seed, &within}) {
      const TestResult r = Independence(*pairs);
      EXPECT_TRUE(r.accepted) << pair << ": " << r.message;
    }
  }
  // The passes of one block are stratified against one another: the test sees dependence where there is some.
  std::vector<Vec2> same_block;
  for (uint32_t i = 0; i < 20000; ++i) same_block.push_back({value(1, i, 0, 3, 0), value(1, i, 0, 4, 0)});
  EXPECT_FALSE(Independence(same_block).accepted);
}

TEST(Sampler, StaysBelowOne) {
  EXPECT_EQ(Sampler::ToUnit(0), 0);
  EXPECT_LT(Sampler::ToUnit(~0u), 1);
}

// Over the pixels for one u, and over the u for one pixel.
TEST(Sampler, RefinesByBitsOfTheirOwn) {
  constexpr uint32_t kCount = 20000;
  std::vector<float> over_pixels, over_u;
  const auto added = [](const Sampler& sampler, float u) {
    const double refined = sampler.Refine(u);
    EXPECT_EQ(std::floor(refined * 0x1p24), double{u} * 0x1p24);
    return static_cast<float>((refined - u) * 0x1p24);
  };
  for (uint32_t i = 0; i < kCount; ++i) {
    over_pixels.push_back(added(Sampler(7, i, 0, 3), 0.3125f));
    over_u.push_back(added(Sampler(7, 0, 0, 3), Sampler::ToUnit(i << 8)));
  }
  EXPECT_LT(Sampler(7, 0, 0, 0).Refine(Sampler::ToUnit(~0u)), 1);
  for (auto* values : {&over_pixels, &over_u}) {
    const TestResult result = ChiSquareUniform(*values, 64, kLevel);
    EXPECT_TRUE(result.accepted) << result.message;
    for (float& value : *values) value *= 0.97f;
    EXPECT_FALSE(ChiSquareUniform(*values, 64, kLevel).accepted);
  }
}

}  // namespace
}  // namespace lodestar::test
