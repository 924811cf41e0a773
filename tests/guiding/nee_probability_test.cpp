#include "core/guiding/nee_probability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

// A vertex whose light sample is `bright` with probability `visible`, seen at share q, beside reflected light that is 0
// or 2 at even odds.
NeeSums Sums(double visible, float bright, float q, int count, uint32_t vertices) {
  NeeSums sums;
  uint64_t rng = 5;
  for (int i = 0; i < count; ++i) {
    const bool taken = synthetic::Unit(rng) < q, seen = synthetic::Unit(rng) < visible;
    sums.Add(taken && seen ? bright / q : 0.0f, synthetic::Unit(rng) < 0.5f ? 2.0f : 0.0f, vertices);
  }
  return sums;
}

// Variance times cost of nee / q + reflected, in closed form.
double Work(double visible, double bright, double q, double vertices) {
  const double second = visible * bright * bright, mean = visible * bright;
  return (second / q + 1 - mean * mean) * (0.5 * q + vertices);
}

TEST(NeeProbability, MinimisesVarianceTimesCost) {
  for (const double visible : {0.02, 0.1})
    for (const uint32_t vertices : {1u, 4u}) {
      const float q = SolveNeeProbability(Sums(visible, 1, 1, 400000, vertices), 1, 128);
      for (double other = kLeastNeeProbability; other <= 1; other += 0.01)
        EXPECT_LE(Work(visible, 1, q, vertices), Work(visible, 1, other, vertices) * 1.001)
            << visible << " " << vertices << " " << other;
    }
}

TEST(NeeProbability, DoesNotDependOnTheShareThatWasUsed) {
  const float full = SolveNeeProbability(Sums(0.05, 1, 1, 400000, 2), 1, 128);
  const float half = SolveNeeProbability(Sums(0.05, 1, 0.5f, 400000, 2), 0.5f, 128);
  EXPECT_NEAR(half / full, 1, 0.05);
}

TEST(NeeProbability, StaysWithinItsRange) {
  EXPECT_EQ(SolveNeeProbability(Sums(0, 1, 1, 1000, 3), 1, 128), kLeastNeeProbability);  // nothing to be seen
  EXPECT_EQ(SolveNeeProbability(Sums(1, 50, 1, 1000, 3), 0.5f, 128), 1);   // light samples are all there is
  EXPECT_EQ(SolveNeeProbability(Sums(0, 1, 1, 100, 3), 0.7f, 128), 0.7f);  // too few records
  EXPECT_EQ(SolveNeeProbability(NeeSums{}, 0.7f, 1), 0.7f);
  NeeSums extreme;
  for (int i = 0; i < 1000; ++i) extreme.Add(1e30f, 1e-30f, 1);
  EXPECT_EQ(SolveNeeProbability(extreme, 1, 128), 1);
  NeeSums broken;
  broken.Add(std::nanf(""), 1, 1);
  broken.Add(1, -1, 1);
  EXPECT_EQ(broken.count, 0u);
}

TEST(NeeProbability, MergingIsExact) {
  NeeSums whole = Sums(0.3, 1.7f, 0.6f, 1000, 2), left, right;
  uint64_t rng = 5;
  for (int i = 0; i < 1000; ++i) {
    const bool taken = synthetic::Unit(rng) < 0.6f, seen = synthetic::Unit(rng) < 0.3;
    (i % 3 ? left : right).Add(taken && seen ? 1.7f / 0.6f : 0.0f, synthetic::Unit(rng) < 0.5f ? 2.0f : 0.0f, 2);
  }
  right.Merge(left);
  EXPECT_EQ(right.direct_squared, whole.direct_squared);
  EXPECT_EQ(right.reflected, whole.reflected);
  EXPECT_EQ(SolveNeeProbability(right, 0.6f, 1), SolveNeeProbability(whole, 0.6f, 1));
}

}  // namespace
}  // namespace lodestar
