#include "core/math/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace lodestar {
namespace {

ExactSum SumOf(const std::vector<float>& values) {
  ExactSum sum;
  for (float v : values) sum.Add(v);
  return sum;
}

std::vector<float> MixedMagnitudes(std::mt19937& rng, int count, bool positive) {
  std::uniform_real_distribution<float> exponent(-30, 15);
  std::vector<float> values;
  for (int i = 0; i < count; ++i) {
    const float magnitude = std::pow(10.0f, exponent(rng));
    values.push_back(positive || rng() % 2 ? magnitude : -magnitude);
  }
  return values;
}

TEST(ExactSum, ConvertsExactly) {
  for (float v : {1.0f, -1.0f, 0.1f, 3.14159f, 1e12f, -1e18f, 0x1p-56f, 0x1.fffffep-33f, 0x1.fffffep69f}) {
    ExactSum sum;
    EXPECT_TRUE(sum.Add(v));
    EXPECT_EQ(sum.Value(), static_cast<double>(v)) << v;
  }
}

TEST(ExactSum, RoundsBelowTheUnitToNearest) {
  const auto units = [](float v) {
    ExactSum sum;
    sum.Add(v);
    return static_cast<long long>(sum.Units());
  };
  EXPECT_EQ(units(0x1p-57f), 1);  // half: away from zero
  EXPECT_EQ(units(-0x1p-57f), -1);
  EXPECT_EQ(units(0x1.fffffep-58f), 0);
  EXPECT_EQ(units(1.49f * 0x1p-56f), 1);
  EXPECT_EQ(units(1.5f * 0x1p-56f), 2);
  EXPECT_EQ(units(0x1.8p-40f + 0x1.0p-62f), 3 << 15);
  EXPECT_EQ(units(1e-30f), 0);
  EXPECT_EQ(units(1e-42f), 0);  // denormal
  EXPECT_EQ(units(0.0f), 0);
  EXPECT_EQ(units(-0.0f), 0);
}

TEST(ExactSum, AgreesWithLongDouble) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  ExactSum sum;
  long double expected = 0;
  for (int i = 0; i < 100000; ++i) {
    const float v = uniform(rng) + 0.01f;
    sum.Add(v);
    expected += v;
  }
  EXPECT_EQ(sum.Value(), static_cast<double>(expected));  // 24 bits + 17 bits fit a long double exactly
}

TEST(ExactSum, AnyPartitionAndOrderGivesTheSameBits) {
  std::mt19937 rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<float> values = MixedMagnitudes(rng, 300, trial % 2 == 0);
    const ExactSum expected = SumOf(values);
    std::shuffle(values.begin(), values.end(), rng);
    // Random pieces, some empty, merged as a random tree.
    std::vector<ExactSum> parts(1 + rng() % 20);
    for (float v : values) parts[rng() % parts.size()].Add(v);
    while (parts.size() > 1) {
      const size_t from = rng() % parts.size();
      const ExactSum taken = parts[from];
      parts.erase(parts.begin() + static_cast<long>(from));
      parts[rng() % parts.size()].Merge(taken);
    }
    ASSERT_EQ(parts[0], expected) << trial;
  }
}

TEST(ExactSum, FloatSumsWouldNot) {
  // The test above must be able to fail: plain float addition does.
  std::mt19937 rng(1);
  std::vector<float> values = MixedMagnitudes(rng, 300, false);
  float a = 0, b = 0;
  for (float v : values) a += v;
  std::reverse(values.begin(), values.end());
  for (float v : values) b += v;
  EXPECT_NE(a, b);
}

TEST(ExactSum, SaturatesInAnyOrder) {
  std::mt19937 rng(3);
  std::vector<float> values(100, 0x1p68f);
  values.insert(values.end(), {1.0f, 1e-9f, 0x1p71f, 3e38f});
  ExactSum expected = SumOf(values);
  EXPECT_TRUE(expected.saturated());
  EXPECT_EQ(expected.Value(), ExactSum::kLimit);
  for (int trial = 0; trial < 50; ++trial) {
    std::shuffle(values.begin(), values.end(), rng);
    std::vector<ExactSum> parts(4);
    for (float v : values) parts[rng() % 4].Add(v);
    for (int i = 1; i < 4; ++i) parts[0].Merge(parts[i]);
    ASSERT_EQ(parts[0], expected);
  }
}

TEST(ExactSum, ReportsAddendsBeyondTheLimit) {
  ExactSum sum;
  EXPECT_TRUE(sum.Add(0x1.fffffep69f));
  EXPECT_FALSE(sum.Add(0x1p70f));
  EXPECT_FALSE(sum.Add(-3e38f));
  EXPECT_TRUE(ExactSum::FromUnits(static_cast<__int128>(1) << 126).saturated());
  const __int128 lowest = static_cast<__int128>(static_cast<unsigned __int128>(1) << 127);
  EXPECT_LT(ExactSum::FromUnits(lowest).Value(), 0);
  EXPECT_TRUE(ExactSum::FromUnits(lowest).saturated());
}

}  // namespace
}  // namespace lodestar
