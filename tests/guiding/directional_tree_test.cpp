#include "core/guiding/directional_tree.h"

#include <gtest/gtest.h>

#include "tests/guiding/synthetic.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using directional::Cell;
using directional::Locate;

// A tree learned from `count` samples of a density, refined over a few rounds as Advance does it.
directional::Tree Learn(const std::function<float(Vec3)>& density, int rounds, int count, int max_depth = 20,
                        float threshold = 0.01f) {
  directional::Tree tree{{DirectionalNode{}}, 1};
  uint64_t rng = 11;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> masses(tree.nodes.size() * 4, 0.0);
    double total = 0;
    for (int i = 0; i < count; ++i) {
      // Half uniform, half from the tree: peaks are found and then resolved.
      Vec3 w = SquareToSphere(synthetic::Unit2(rng));
      if (i % 2) w = CylindricalToDirection(directional::Sample(tree.nodes.data(), synthetic::Unit2(rng)).square);
      const Cell cell = Locate(tree.nodes.data(), DirectionToCylindrical(w));
      const double value = density(w) / (0.5 * kUniformSpherePdf + 0.5 * cell.density);
      masses[cell.slot] += value;
      total += value;
    }
    if (total > 0)
      tree = directional::Rebuild(tree.nodes.data(), static_cast<uint32_t>(tree.nodes.size()), masses, threshold,
                                  max_depth);
  }
  return tree;
}

directional::Tree OneSample(Vec2 square, int max_depth) {
  directional::Tree tree{{DirectionalNode{}}, 1};
  for (int round = 0; round < 30; ++round) {
    std::vector<double> masses(tree.nodes.size() * 4, 0.0);
    masses[Locate(tree.nodes.data(), square).slot] = 1;
    tree = directional::Rebuild(tree.nodes.data(), static_cast<uint32_t>(tree.nodes.size()), masses, 0.01, max_depth);
  }
  return tree;
}

float Lobe(Vec3 axis, float kappa, Vec3 w) {
  return kappa * Exp(kappa * (Dot(axis, w) - 1));
}

struct Case {
  const char* name;
  directional::Tree tree;
};
std::vector<Case> Cases() {
  const Vec3 across = Normalize(Vec3{1, -0.001f, 0.3f});
  return {
      {"empty", {{DirectionalNode{}}, 1}},
      {"trained", Learn(
                      [](Vec3 w) {
                        return synthetic::MovingLobes({0.3f, 0.6f, 0.2f}, w);
                      },
                      5, 20000)},
      {"across phi = 0", Learn([&](Vec3 w) { return Lobe(across, 3000, w); }, 6, 20000)},
      {"pole", Learn(
                   [](Vec3 w) {
                     return Lobe({0, 0, 1}, 3000, w);
                   },
                   6, 20000)},
      {"other pole", Learn(
                         [](Vec3 w) {
                           return Lobe({0, 0, -1}, 50, w) + 0.01f;
                         },
                         6, 20000)},
      {"one sample, shallow", OneSample({0.3f, 0.7f}, 5)},
      {"narrow", Learn(
                     [](Vec3 w) {
                       return 0.01f + Lobe(Normalize(Vec3{1, 2, 3}), 1e5f, w);
                     },
                     9, 20000, 12)},
  };
}

// Chi-square over quarters of the cells: the choice of cells at any depth, and uniformity within each. The sphere test
// of tests/support integrates densities by quadrature, which the jumps of this one defeat; here the expectations are
// known in closed form. `skew` shifts the expected mass from even to odd slots: a wrong pdf.
test::TestResult CellTest(const directional::Tree& tree, double level, double skew = 0) {
  const DirectionalNode* const nodes = tree.nodes.data();
  std::vector<double> observed(tree.nodes.size() * 16), expected(observed.size());
  constexpr int kSamples = 200000;
  const auto visit = [&](auto& self, uint32_t node, uint32_t x, uint32_t y, int depth) -> void {
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t size = (1u << 24) >> (depth + 1), cx = x + (c & 1) * size, cy = y + (c >> 1) * size;
      if (nodes[node].child[c] != 0) {
        self(self, nodes[node].child[c], cx, cy, depth + 1);
        continue;
      }
      const double mass =
          Locate(nodes, cx, cy).density / kUniformSpherePdf * std::pow(0.25, depth + 1) * (1 + (c % 2 ? skew : -skew));
      for (int quarter = 0; quarter < 4; ++quarter) expected[(node * 4 + c) * 4 + quarter] = kSamples * mass / 4;
    }
  };
  visit(visit, 0, 0, 0, 0);
  uint64_t rng = 9;
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 s = directional::Sample(nodes, synthetic::Unit2(rng)).square;
    const uint32_t x = directional::ToInteger(s.x), y = directional::ToInteger(s.y);
    const Cell cell = Locate(nodes, x, y);
    const int shift = 23 - cell.depth;
    // A point that rounds over the border of its cell is SdTree::Sample's to repair.
    if (cell.density == 0) continue;
    observed[cell.slot * 4 + ((x >> shift) & 1) + 2 * ((y >> shift) & 1)] += 1;
  }
  return test::ChiSquareTest(observed, expected, level, 20);
}

TEST(DirectionalTree, SamplesFollowThePdf) {
  const auto cases = Cases();
  const double level = test::SidakLevel(0.01, static_cast<int>(cases.size()));
  for (const Case& c : cases) {
    const auto result = CellTest(c.tree, level);
    EXPECT_TRUE(result.accepted) << c.name << ": " << result.message;
  }
}

TEST(DirectionalTree, AWrongPdfIsRejected) {
  for (const Case& c : Cases()) EXPECT_FALSE(CellTest(c.tree, 1e-3, 0.1).accepted) << c.name;
}

double Integral(const directional::Tree& tree, uint32_t node, uint32_t x, uint32_t y, int depth) {
  double sum = 0;
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t size = (1u << 24) >> (depth + 1), cx = x + (c & 1) * size, cy = y + (c >> 1) * size;
    if (tree.nodes[node].child[c] != 0) {
      sum += Integral(tree, tree.nodes[node].child[c], cx, cy, depth + 1);
    } else {
      const Cell cell = Locate(tree.nodes.data(), cx + size / 2, cy + size / 2);
      EXPECT_EQ(cell.slot, node * 4 + c);
      sum += cell.density * std::pow(0.25, depth + 1) / kUniformSpherePdf;
    }
  }
  return sum;
}

TEST(DirectionalTree, IntegratesToOne) {
  auto cases = Cases();
  cases.push_back({"maximum depth", OneSample({0.123456f, 0.987654f}, 20)});
  for (const Case& c : cases) EXPECT_NEAR(Integral(c.tree, 0, 0, 0, 0), 1, 1e-5) << c.name;
  EXPECT_EQ(cases.back().tree.depth, 20);
}

TEST(DirectionalTree, RoundTripStaysWithinItsBound) {
  uint64_t rng = 21;
  double worst = 0;
  for (int i = 0; i < 2000000; ++i) {
    Vec2 s = synthetic::Unit2(rng);
    if (i % 4 == 1) s.x = s.x * 1e-4f;  // near a pole
    if (i % 4 == 2) s.x = 1 - s.x * 1e-4f;
    if (i % 4 == 3) s.y = s.y * 1e-5f;
    s.x = std::min(s.x, kOneMinusEpsilon);
    const Vec2 back = DirectionToCylindrical(CylindricalToDirection(s));
    double dy = std::fabs(back.y - s.y);
    dy = std::min(dy, 1 - dy);                         // around
    const bool pole = s.x < 1e-6f || s.x > 1 - 1e-6f;  // phi is lost there
    worst = std::max({worst, static_cast<double>(std::fabs(back.x - s.x)), pole ? 0 : dy});
  }
  EXPECT_LT(worst * 2, directional::kRoundTrip);
}

TEST(DirectionalTree, FootprintConservesMassAndWraps) {
  for (const Case& c : Cases()) {
    const DirectionalNode* const nodes = c.tree.nodes.data();
    uint64_t rng = 5;
    for (int i = 0; i < 20000; ++i) {
      Vec2 s = synthetic::Unit2(rng);
      if (i % 3 == 0) s.y = (i % 2) ? 1e-7f : kOneMinusEpsilon;
      if (i % 5 == 0) s.x = (i % 2) ? 0 : kOneMinusEpsilon;
      const uint32_t x = directional::ToInteger(s.x), y = directional::ToInteger(s.y);
      const Cell cell = Locate(nodes, x, y);
      double sum = 0, own = 0;
      directional::ForFootprint(nodes, x, y, cell, [&](uint32_t slot, float share) {
        ASSERT_GT(share, 0);
        sum += share;
        if (slot == cell.slot) own += share;
      });
      ASSERT_NEAR(sum, 1, 1e-6) << c.name;
      ASSERT_GE(own, 0.25 - 1e-6) << c.name;
    }
  }
  // The uniform tree, a point just above phi = 0: half of its footprint lies below 2 pi.
  const std::vector<DirectionalNode> uniform(1);
  const Cell cell = Locate(uniform.data(), 1u << 22, 0);
  std::vector<double> per_slot(4);
  directional::ForFootprint(uniform.data(), 1u << 22, 0, cell,
                            [&](uint32_t slot, float share) { per_slot[slot] += share; });
  EXPECT_NEAR(per_slot[0], 0.5, 1e-6);
  EXPECT_NEAR(per_slot[2], 0.5, 1e-6);
}

// Against the definition: overlap areas, found by brute force over a grid of points of the footprint.
TEST(DirectionalTree, FootprintSharesAreAreas) {
  const auto cases = Cases();
  const DirectionalNode* const nodes = cases[1].tree.nodes.data();
  uint64_t rng = 8;
  for (int i = 0; i < 200; ++i) {
    const uint32_t x = directional::ToInteger(synthetic::Unit(rng)), y = directional::ToInteger(synthetic::Unit(rng));
    const Cell cell = Locate(nodes, x, y);
    const uint32_t size = (1u << 24) >> cell.depth;
    const uint32_t x0 = std::min(x - std::min(x, size / 2), (1u << 24) - size), y0 = y - size / 2;
    std::vector<double> shares(cases[1].tree.nodes.size() * 4), expected(shares.size());
    directional::ForFootprint(nodes, x, y, cell, [&](uint32_t slot, float share) { shares[slot] += share; });
    constexpr uint32_t kGrid = 48;
    for (uint32_t gy = 0; gy < kGrid; ++gy) {
      for (uint32_t gx = 0; gx < kGrid; ++gx) {
        const uint32_t px = x0 + static_cast<uint32_t>((gx + 0.5) / kGrid * size),
                       py = (y0 + static_cast<uint32_t>((gy + 0.5) / kGrid * size)) & 0xffffff;
        expected[Locate(nodes, px, py).slot] += 1.0 / (kGrid * kGrid);
      }
    }
    for (size_t slot = 0; slot < shares.size(); ++slot) ASSERT_NEAR(shares[slot], expected[slot], 0.04);
  }
}

TEST(DirectionalTree, RefinesByFluxAndCollapses) {
  // All mass in one cell: it splits to quarters until each holds no more than 1 %: 4^-4 < 0.01 < 4^-3, so four levels
  // below the cell's own.
  DirectionalNode root;
  directional::Tree tree = directional::Rebuild(&root, 1, {0, 0, 0, 1}, 0.01, 20);
  EXPECT_EQ(tree.depth, 1 + 4);
  EXPECT_EQ(tree.nodes.size(), 1u + 1 + 4 + 16 + 64);
  EXPECT_FLOAT_EQ(Locate(tree.nodes.data(), Vec2{0.9f, 0.9f}).density, 4 * kUniformSpherePdf);
  EXPECT_EQ(Locate(tree.nodes.data(), Vec2{0.1f, 0.1f}).density, 0);
  // The depth limit holds.
  EXPECT_EQ(directional::Rebuild(&root, 1, {0, 0, 0, 1}, 0.01, 3).depth, 3);
  // Mass elsewhere: the old subtree goes, and its mass counts as its parent's.
  std::vector<double> masses(tree.nodes.size() * 4, 0.0);
  masses[Locate(tree.nodes.data(), Vec2{0.1f, 0.1f}).slot] = 1000;
  masses[Locate(tree.nodes.data(), Vec2{0.9f, 0.9f}).slot] = 1;
  const directional::Tree collapsed =
      directional::Rebuild(tree.nodes.data(), static_cast<uint32_t>(tree.nodes.size()), masses, 0.01, 20);
  EXPECT_EQ(Locate(collapsed.nodes.data(), Vec2{0.9f, 0.9f}).depth, 1);
  EXPECT_NEAR(Locate(collapsed.nodes.data(), Vec2{0.9f, 0.9f}).density, 4 * kUniformSpherePdf / 1001, 1e-5);
}

// Depth first, likeliest child first, ties by index: what the serial form counts on.
uint32_t ExpectLaidOut(const directional::Tree& tree, uint32_t node) {
  uint32_t next = node + 1;
  for (const int c : directional::LikeliestFirst(tree.nodes[node])) {
    if (tree.nodes[node].child[c] == 0) continue;
    EXPECT_EQ(tree.nodes[node].child[c], next) << "child " << c << " of node " << node;
    next = ExpectLaidOut(tree, next);
  }
  return next;
}

TEST(DirectionalTree, SubtreesAreLaidOutLikeliestFirst) {
  for (const double skew : {0.0, 1.0}) {  // without it, all children of all nodes tie
    DirectionalNode root;
    directional::Tree tree = directional::Rebuild(&root, 1, {1, 1, 1, 1}, 0.002, 20);
    ASSERT_EQ(tree.nodes.size(), 1u + 4 + 16 + 64 + 256);
    uint64_t rng = 5;
    for (int round = 0; round < 4; ++round) {
      std::vector<double> masses(tree.nodes.size() * 4, 0.0);
      for (size_t slot = 0; slot < masses.size(); ++slot) {
        if (tree.nodes[slot / 4].child[slot % 4] == 0) masses[slot] = 1 + 20 * skew * synthetic::Unit(rng);
      }
      tree = directional::Rebuild(tree.nodes.data(), static_cast<uint32_t>(tree.nodes.size()), masses, 0.002, 20);
      EXPECT_EQ(ExpectLaidOut(tree, 0), tree.nodes.size());
    }
  }
}

TEST(DirectionalTree, TheLimitOnNodesLeavesOutTheFinest) {
  DirectionalNode root;
  const directional::Tree tree = directional::Rebuild(&root, 1, {1, 1, 1, 1}, 1e-9, 20);
  EXPECT_LE(tree.nodes.size(), directional::kMaxNodes);
  EXPECT_EQ(tree.depth, 9);  // 4^8 nodes of depth 9 and those above them are too many
  for (float x = 0.01f; x < 1; x += 0.07f) {
    for (float y = 0.01f; y < 1; y += 0.07f) EXPECT_GE(Locate(tree.nodes.data(), Vec2{x, y}).depth, 8);
  }
}

}  // namespace
}  // namespace lodestar
