#include "core/guiding/product_distribution.h"

#include <gtest/gtest.h>

#include <numeric>
#include <unordered_map>

#include "tests/guiding/product_cases.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using product_cases::Centre;
using product_cases::ForCells;

uint64_t Key(uint32_t x, uint32_t y, int depth) {
  return (static_cast<uint64_t>(depth) << 56) | (static_cast<uint64_t>(x) << 24) | y;
}

// The cells over which the density is even, and the density.
struct Cells {
  Cells(const directional::Tree& tree, const ProductDistribution& product)
      : tree(tree), product(product), finest(product.finest_level()) {
    ForCells(tree, finest, [&](uint32_t x, uint32_t y, int depth) {
      index[Key(x, y, depth)] = mass.size();
      const Vec3 w = Centre(x, y, depth);
      const float pdf = product.Pdf(w);
      mass.push_back(pdf / kUniformSpherePdf * std::ldexp(1.0, -2 * depth));
      const float by_tree = directional::Locate(tree.nodes.data(), DirectionToCylindrical(w)).density;
      if (by_tree > 0) least_ratio = std::min(least_ratio, static_cast<double>(pdf) / by_tree);
    });
  }
  // `skew` shifts expected mass from even to odd cells: a wrong pdf.
  test::TestResult ChiSquare(int samples, double level, double skew = 0) const {
    std::vector<double> expected(mass), observed(mass.size());
    for (size_t i = 0; i < mass.size(); ++i) expected[i] *= samples * (1 + (i % 2 ? skew : -skew));
    ForSamples(samples, [&](size_t cell, uint32_t) { observed[cell] += 1; });
    return test::ChiSquareTest(observed, expected, level, 20);
  }
  // Of so many samples, how many fall into each quarter of each cell, 4 cell + quarter.
  std::vector<double> CountInQuarters(int samples) const {
    std::vector<double> observed(4 * mass.size());
    ForSamples(samples, [&](size_t cell, uint32_t quarter) { observed[4 * cell + quarter] += 1; });
    return observed;
  }
  // `tilt` moves mass from even to odd quarters of each cell: a wrong pdf, which cells as wholes do not show.
  std::vector<double> ExpectedInQuarters(int samples, double tilt = 0) const {
    std::vector<double> expected(4 * mass.size());
    for (size_t i = 0; i < expected.size(); ++i) expected[i] = samples * mass[i / 4] / 4 * (1 + (i % 2 ? tilt : -tilt));
    return expected;
  }

  // Calls visit(cell, quarter) for each sample: where it falls, the quarter being x + 2 y.
  template <class Visit>
  void ForSamples(int samples, Visit&& visit) const {
    uint64_t rng = 9;
    for (int i = 0; i < samples; ++i) {
      const Vec2 s = DirectionToCylindrical(product.Sample(synthetic::Unit2(rng)).w);
      const uint32_t x = directional::ToInteger(s.x), y = directional::ToInteger(s.y);
      const int depth = std::max(directional::Locate(tree.nodes.data(), x, y).depth, finest), shift = 23 - depth;
      visit(index.at(Key(x >> (24 - depth), y >> (24 - depth), depth)), ((x >> shift) & 1) + 2 * ((y >> shift) & 1));
    }
  }

  const directional::Tree& tree;
  const ProductDistribution& product;
  int finest;
  std::unordered_map<uint64_t, size_t> index;
  std::vector<double> mass;
  double least_ratio = 1;
};

template <class Check>
void ForCasesOf(const product_cases::TreeCase& t, Check&& check) {
  const TreeTop top(t.tree.nodes.data());
  for (const auto& s : product_cases::Surfaces()) {
    SCOPED_TRACE(t.name + ", " + s.name);
    const ProductDistribution product(t.tree.nodes.data(), top, s.Lobes());
    if (product.usable()) check(t.tree, product);
  }
}

template <class Check>
void ForAllCases(Check&& check) {
  for (const auto& t : product_cases::Trees()) ForCasesOf(t, check);
}

TEST(ProductDistribution, IntegratesToOneSamplesFollowItAndTheTreeBoundsIt) {
  const double level = test::SidakLevel(0.01, 9 * 22);
  int tested = 0, with_narrow = 0;
  ForAllCases([&](const directional::Tree& tree, const ProductDistribution& product) {
    const Cells cells(tree, product);
    EXPECT_NEAR(std::accumulate(cells.mass.begin(), cells.mass.end(), 0.0), 1, 1e-4);
    // Whatever the lobes and their integrals (docs/decisions/0009): bounded variance never depends on them.
    // Where no lobe is narrow, one choice alone follows the block's. 1 % for rounding: the unlikeliest part of a node,
    // 2^-15, is the rest of 1 in floats, twice, each time off by 2^-9 of itself at most; it has no node below it.
    const bool to_the_finest = cells.finest == product::kFinest;
    EXPECT_GE(cells.least_ratio, 0.99 * (to_the_finest ? ProductDistribution::kLeastRatio : 1.0 / 512));
    with_narrow += to_the_finest;
    const auto result = cells.ChiSquare(15000, level);
    EXPECT_TRUE(result.accepted) << result.message;
    ++tested;
  });
  EXPECT_GT(tested, 160);
  EXPECT_GT(with_narrow, 20);
  EXPECT_GT(tested - with_narrow, 40);
}

TEST(ProductDistribution, AWrongPdfIsRejected) {
  const auto trees = product_cases::Trees();
  const TreeTop top(trees[1].tree.nodes.data());
  for (const auto& s : product_cases::Surfaces()) {
    const ProductDistribution product(trees[1].tree.nodes.data(), top, s.Lobes());
    EXPECT_FALSE(Cells(trees[1].tree, product).ChiSquare(30000, 1e-3, 0.12).accepted) << s.name;
  }
}

// Cells are no smaller than 2^-12 here: wide against what the rounding of a direction moves.
TEST(ProductDistribution, SamplesAreEvenWithinCells) {
  constexpr int kSamples = 100000;
  const double level = test::SidakLevel(0.01, 2 * 22);
  const auto trees = product_cases::Trees();
  int tested = 0;
  for (const size_t tree : {1, 8}) {
    ForCasesOf(trees[tree], [&](const directional::Tree& of, const ProductDistribution& product) {
      const Cells cells(of, product);
      const std::vector<double> observed = cells.CountInQuarters(kSamples);
      const auto even = test::ChiSquareTest(observed, cells.ExpectedInQuarters(kSamples), level, 20);
      EXPECT_TRUE(even.accepted) << even.message;
      const auto tilted = test::ChiSquareTest(observed, cells.ExpectedInQuarters(kSamples, 0.25), 1e-3, 20);
      EXPECT_FALSE(tilted.accepted) << tilted.message;
      ++tested;
    });
  }
  EXPECT_GT(tested, 30);
}

TEST(ProductDistribution, SampleAndPdfAgreeBitForBit) {
  ForAllCases([](const directional::Tree&, const ProductDistribution& product) {
    uint64_t rng = 3;
    for (int i = 0; i < 2000; ++i) {
      Vec2 u = synthetic::Unit2(rng);
      if (i % 10 == 0) u.x = i % 20 ? 0 : kOneMinusEpsilon;
      if (i % 15 == 0) u.y = i % 30 ? 0 : kOneMinusEpsilon;
      const GuidedSample sample = product.Sample(u);
      ASSERT_TRUE(std::isfinite(sample.pdf) && sample.pdf > 0);
      ASSERT_NEAR(Length(sample.w), 1, 1e-5);
      ASSERT_EQ(sample.pdf, product.Pdf(sample.w)) << i;
    }
  });
}

TEST(ProductDistribution, IsUnusableWhereNothingIsReflected) {
  const auto below = product_cases::OnePoint({0.01f, 0.7f}, 5);
  const TreeTop top(below.nodes.data());
  const ProductLobe diffuse{ProductLobe::Kind::kDiffuseReflection, 1, 1};
  EXPECT_FALSE(ProductDistribution(below.nodes.data(), top, ProductLobes({}, {0, 0, 1}, {&diffuse, 1})).usable());
  EXPECT_TRUE(ProductDistribution(below.nodes.data(), top, ProductLobes({}, {0, 0, -1}, {&diffuse, 1})).usable());
  EXPECT_FALSE(ProductDistribution(below.nodes.data(), top, ProductLobes({}, {0, 0, -1}, {})).usable());
  const ProductLobe black{ProductLobe::Kind::kGgxReflection, 0.1f, 0};
  EXPECT_FALSE(ProductDistribution(below.nodes.data(), top, ProductLobes({}, {0, 0, -1}, {&black, 1})).usable());
}

}  // namespace
}  // namespace lodestar
