#include <gtest/gtest.h>

#include <algorithm>

#include "core/guiding/reconstruction_lanes.h"
#include "core/guiding/reconstruction_shrinkage.h"
#include "tests/guiding/recorded_tree.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using directional::CellMasses;
using directional::ReconstructNative;
using directional::Tree;
using synthetic::ForEachCell;
using synthetic::RecordedTree;
using synthetic::SameNodes;

double Lobe(Vec3 axis, double kappa, Vec3 w) {
  return kappa * std::exp(kappa * (static_cast<double>(Dot(Normalize(axis), w)) - 1));
}
double Sky(Vec3 w) {
  return (w.z > 0 ? 0.3 : 0.1) + Lobe({1, -0.2f, 0.3f}, 2, w);
}
double Lamp(Vec3 w) {
  return 0.01 + Lobe({1, 2, 1}, 2000, w);
}

double Density(const Tree& tree, float x, float y) {
  return directional::Locate(tree.nodes.data(), Vec2{x, y}).density / kUniformSpherePdf;
}
double Mass(const directional::Cell& cell) {
  return std::ldexp(static_cast<double>(cell.density) / kUniformSpherePdf, -2 * cell.depth);
}

// A tree refined everywhere to `depth`.
Tree Uniform(int depth) {
  DirectionalNode root;
  return directional::Rebuild(&root, 1, {1, 1, 1, 1}, 0.99 * std::ldexp(1.0, -2 * (depth - 1)), depth);
}

// The masses of `records` points drawn from density(x, y) over the square into a tree, in two halves.
RecordedTree Draw(Tree tree, int records, uint64_t seed, const std::function<Vec2(uint64_t&)>& point) {
  RecordedTree t;
  t.tree = std::move(tree);
  const size_t slots = t.tree.nodes.size() * 4;
  t.masses = {t.tree.nodes.data(), static_cast<uint32_t>(t.tree.nodes.size()), std::vector<double>(slots), {}};
  t.masses.halves.fill(t.masses.total);
  uint64_t rng = Mix64(seed);
  for (int i = 0; i < records; ++i) {
    const uint32_t slot = directional::Locate(t.masses.nodes, point(rng)).slot;
    t.masses.total[slot] += 1;
    t.masses.halves[i & 1][slot] += 1;
  }
  return t;
}

std::vector<RecordedTree> NoisyTrees() {
  std::vector<RecordedTree> trees;
  for (const auto& radiance : {std::function<double(Vec3)>(Sky), std::function<double(Vec3)>(Lamp)}) {
    for (int records : {150, 1000, 10000}) {
      trees.push_back(synthetic::Record({.radiance = radiance, .records = records, .second_moment = records == 1000}));
    }
  }
  return trees;
}

TEST(NativeReconstruction, ConservesMassAndReachesWhatWasRecorded) {
  for (const RecordedTree& t : NoisyTrees()) {
    const Tree tree = ReconstructNative(t.masses, 0.01, 20);
    double sum = 0;
    ForEachCell(tree, [&](uint32_t, uint32_t x, uint32_t y, int depth) {
      sum += Mass(directional::Locate(tree.nodes.data(), x << (24 - depth), y << (24 - depth)));
    });
    EXPECT_NEAR(sum, 1, 1e-5);
    double total = 0;
    for (double m : t.masses.total) total += m;
    ForEachCell(t.tree, [&](uint32_t slot, uint32_t x, uint32_t y, int depth) {
      if (t.masses.total[slot] == 0) return;
      const double density = directional::Locate(tree.nodes.data(), x << (24 - depth), y << (24 - depth)).density;
      ASSERT_GT(density, 0);
    });
  }
}

// The probability that a tree gives to a square at `depth`, whole or in cells of its own.
double MassOver(const Tree& tree, uint32_t x, uint32_t y, int depth) {
  const auto cell = directional::Locate(tree.nodes.data(), x << (24 - depth), y << (24 - depth));
  if (cell.depth <= depth) return std::ldexp(static_cast<double>(cell.density) / kUniformSpherePdf, -2 * depth);
  double sum = 0;
  for (uint32_t c = 0; c < 4; ++c) sum += MassOver(tree, 2 * x + (c & 1), 2 * y + (c >> 1), depth + 1);
  return sum;
}

// The floor that smoothing leaves of what was recorded (0.37). The threshold is so low that the result has every one of
// these cells, if not finer ones.
TEST(NativeReconstruction, KeepsAThirdOfEveryCell) {
  int checked = 0;
  double least = 1;
  for (const RecordedTree& t : NoisyTrees()) {
    const Tree tree = ReconstructNative(t.masses, 0.0005, 20);
    double total = 0;
    for (const double m : t.masses.total) total += m;
    ForEachCell(t.tree, [&](uint32_t slot, uint32_t x, uint32_t y, int depth) {
      const double share = t.masses.total[slot] / total;
      if (share < 0.005) return;
      const double kept = MassOver(tree, x, y, depth) / share;
      EXPECT_GE(kept, 0.36) << "of " << share << " at depth " << depth;
      least = std::min(least, kept);
      ++checked;
    });
  }
  EXPECT_GT(checked, 50);
  EXPECT_LT(least, 0.9);  // and smoothing has taken from some
}

test::TestResult SampleTest(const Tree& tree, double level, double skew) {
  std::vector<double> observed(tree.nodes.size() * 4), expected(observed.size());
  constexpr int kSamples = 200000;
  ForEachCell(tree, [&](uint32_t slot, uint32_t x, uint32_t y, int depth) {
    expected[slot] = kSamples * Mass(directional::Locate(tree.nodes.data(), x << (24 - depth), y << (24 - depth))) *
                     (slot % 2 ? 1 + skew : 1 - skew);
  });
  uint64_t rng = 4;
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 s = directional::Sample(tree.nodes.data(), synthetic::Unit2(rng)).square;
    observed[directional::Locate(tree.nodes.data(), s).slot] += 1;
  }
  return test::ChiSquareTest(observed, expected, level, 20);
}

TEST(NativeReconstruction, SamplesFollowThePdf) {
  const auto trees = NoisyTrees();
  const double level = test::SidakLevel(0.01, static_cast<int>(trees.size()));
  for (const RecordedTree& t : trees) {
    const Tree tree = ReconstructNative(t.masses, 0.01, 20);
    const auto result = SampleTest(tree, level, 0);
    EXPECT_TRUE(result.accepted) << result.message;
    EXPECT_FALSE(SampleTest(tree, level, 0.1).accepted);
  }
}

TEST(NativeReconstruction, HalfATurnAndAMirrorOfTheInputAreThoseOfTheOutput) {
  const auto lopsided = [](uint64_t& rng) {
    const Vec2 u = synthetic::Unit2(rng);
    return Vec2{u.x * u.x, 0.3f * u.y};
  };
  struct Symmetry {
    const char* name;
    std::function<Vec2(Vec2)> map;
  };
  const auto around = [](float y) { return y - std::floor(y); };
  const Symmetry symmetries[] = {
      {"half a turn",
       [&](Vec2 s) {
         return Vec2{s.x, around(s.y + 0.5f)};
       }},
      {"mirror in phi",
       [](Vec2 s) {
         return Vec2{s.x, kOneMinusEpsilon - s.y};
       }},
      {"other pole up",
       [](Vec2 s) {
         return Vec2{kOneMinusEpsilon - s.x, s.y};
       }},
  };
  const RecordedTree t = Draw(Uniform(5), 400, 1, lopsided);
  const Tree tree = ReconstructNative(t.masses, 0.001, 5);
  for (const Symmetry& symmetry : symmetries) {
    const RecordedTree turned = Draw(Uniform(5), 400, 1, [&](uint64_t& rng) { return symmetry.map(lopsided(rng)); });
    const Tree result = ReconstructNative(turned.masses, 0.001, 5);
    double moved = 0;
    for (float x = 1 / 64.0f; x < 1; x += 1 / 32.0f) {
      for (float y = 1 / 64.0f; y < 1; y += 1 / 32.0f) {
        const Vec2 to = symmetry.map({x, y});
        const double here = Density(tree, x, y), there = Density(result, to.x, to.y);
        ASSERT_NEAR(here, there, 2e-3 * here + 1e-4) << symmetry.name;
        moved += std::fabs(here - Density(result, x, y));
      }
    }
    EXPECT_GT(moved, 100);  // the symmetry is not one of the input
  }
}

// All records in the squares of one side of a seam: the squares on its other side expect more than those far from it.
TEST(NativeReconstruction, SeesAcrossPhiZeroAndThePoles) {
  const RecordedTree seam = Draw(Uniform(5), 60, 2, [](uint64_t& rng) {
    const Vec2 u = synthetic::Unit2(rng);
    return Vec2{u.x, u.y * 0.03f};
  });
  const Tree across = ReconstructNative(seam.masses, 1e-5, 5);
  EXPECT_GT(Density(across, 0.4f, 0.99f), 3 * Density(across, 0.4f, 0.51f));
  const RecordedTree pole = Draw(Uniform(5), 60, 3, [](uint64_t& rng) {
    const Vec2 u = synthetic::Unit2(rng);
    return Vec2{u.x * 0.03f, 0.3f + u.y * 0.1f};
  });
  const Tree over = ReconstructNative(pole.masses, 1e-5, 5);
  EXPECT_GT(Density(over, 0.01f, 0.85f), 1.5 * Density(over, 0.99f, 0.85f));
  EXPECT_GT(Density(over, 0.01f, 0.85f), Density(over, 0.01f, 0.6f));
}

TEST(NativeReconstruction, HandlesOneRecordAndOneDirection) {
  for (const int max_depth : {1, 5, 20}) {
    RecordedTree t;
    t.tree = {{DirectionalNode{}}, 1};
    for (int round = 0; round < 25; ++round) {
      t.masses = {t.tree.nodes.data(), static_cast<uint32_t>(t.tree.nodes.size()), {}, {}};
      t.masses.total.assign(t.tree.nodes.size() * 4, 0.0);
      t.masses.halves.fill(t.masses.total);
      const uint32_t slot = directional::Locate(t.masses.nodes, Vec2{0.3f, 0.7f}).slot;
      t.masses.total[slot] = 1;
      t.masses.halves[round % 2][slot] = 1;
      Tree next = ReconstructNative(t.masses, 0.01, max_depth);
      ASSERT_LE(next.depth, max_depth);
      const double density = Density(next, 0.3f, 0.7f);
      ASSERT_TRUE(std::isfinite(density));
      ForEachCell(next, [&](uint32_t, uint32_t x, uint32_t y, int depth) {
        const auto cell = directional::Locate(next.nodes.data(), x << (24 - depth), y << (24 - depth));
        ASSERT_TRUE(std::isfinite(cell.density));
        ASSERT_LE(cell.density / kUniformSpherePdf, density * 1.001);
      });
      t.tree = std::move(next);
    }
    EXPECT_GT(Density(t.tree, 0.3f, 0.7f), max_depth > 1 ? 2 : 0.5);
  }
}

TEST(NativeReconstruction, DoesNotDependOnScale) {
  for (const RecordedTree& t : NoisyTrees()) {
    const Tree tree = ReconstructNative(t.masses, 0.01, 20);
    const auto scaled = [&](double factor) {
      CellMasses m = t.masses;
      for (double& v : m.total) v *= factor;
      for (auto& half : m.halves)
        for (double& v : half) v *= factor;
      return m;
    };
    for (int exponent : {-40, 1, 40, 300})
      EXPECT_TRUE(SameNodes(tree, ReconstructNative(scaled(std::ldexp(1.0, exponent)), 0.01, 20)));
    for (double factor : {1e-12, 1e12}) {
      const Tree other = ReconstructNative(scaled(factor), 0.01, 20);
      ForEachCell(tree, [&](uint32_t, uint32_t x, uint32_t y, int depth) {
        const auto a = directional::Locate(tree.nodes.data(), x << (24 - depth), y << (24 - depth));
        const auto b = directional::Locate(other.nodes.data(), x << (24 - depth), y << (24 - depth));
        if (a.depth != b.depth) return;
        ASSERT_NEAR(a.density, b.density, 2e-3 * a.density + 1e-4);
      });
    }
  }
}

TEST(NativeReconstruction, LeavesAloneWhatIsWellSampled) {
  // A narrow lamp, a million records: noise below the least gain.
  const auto lamp = [](uint64_t& rng) {
    const Vec2 u = synthetic::Unit2(rng);
    if (synthetic::Unit(rng) < 0.1f) return u;
    return Vec2{0.34f + 0.004f * u.x, 0.61f + 0.004f * u.y};
  };
  Tree tree{{DirectionalNode{}}, 1};
  for (int round = 0; round < 3; ++round) tree = synthetic::Plain(Draw(tree, 20000, 5, lamp).masses, 0.01, 20);
  ASSERT_GE(tree.depth, 8);
  const RecordedTree many = Draw(tree, 300000, 6, lamp);
  EXPECT_TRUE(directional::InferShrinkage(many.masses).needless);
  EXPECT_TRUE(SameNodes(ReconstructNative(many.masses, 0.01, 20), synthetic::Plain(many.masses, 0.01, 20)));
  // With a thousand it is smoothed, but the lamp is still there.
  const RecordedTree few = Draw(tree, 1000, 7, lamp);
  EXPECT_FALSE(directional::InferShrinkage(few.masses).needless);
  const Tree smoothed = ReconstructNative(few.masses, 0.01, 20), plain = synthetic::Plain(few.masses, 0.01, 20);
  EXPECT_NEAR(Density(smoothed, 0.342f, 0.612f) / Density(plain, 0.342f, 0.612f), 1, 0.2);
}

// Logarithm of the second moment of estimates that the tree guides, half of them uniform, over the squared mean.
double LogSecondMoment(const Tree& tree, const std::function<double(Vec3)>& radiance) {
  double squares = 0, sum = 0;
  uint64_t rng = 99;
  constexpr int kPoints = 20000;
  for (int i = 0; i < kPoints; ++i) {
    const Vec2 s = synthetic::Unit2(rng);
    const double f = radiance(CylindricalToDirection(s));
    sum += f;
    squares += f * f / (0.5 + 0.5 * Density(tree, s.x, s.y));
  }
  return std::log(squares * kPoints / (sum * sum));
}

TEST(NativeReconstruction, ImprovesTheSecondMomentOfNoisyTrees) {
  const auto window = [](Vec3 w) {
    const bool inside = w.x > 0 && std::fabs(w.y) < 0.4f * w.x && w.z > 0.1f * w.x && w.z < 0.9f * w.x;
    return inside ? 4.0 : 0.1;
  };
  struct Case {
    const char* name;
    std::function<double(Vec3)> radiance;
    bool second_moment;
  };
  const Case cases[] = {
      {"sky", Sky, false}, {"sky, squares", Sky, true}, {"window", window, false}, {"window, squares", window, true}};
  const double level = test::SidakLevel(0.01, 4);
  for (const Case& c : cases) {
    test::Moments gain;
    for (uint64_t seed = 1; seed <= 12; ++seed) {
      const RecordedTree t =
          synthetic::Record({.radiance = c.radiance, .records = 600, .second_moment = c.second_moment, .seed = seed});
      gain.Add(LogSecondMoment(synthetic::Plain(t.masses, 0.01, 20), c.radiance) -
               LogSecondMoment(ReconstructNative(t.masses, 0.01, 20), c.radiance));
    }
    EXPECT_GT(gain.mean(), 0.01) << c.name;
    EXPECT_FALSE(test::TTest(gain, 0, level).accepted) << c.name << " gains " << gain.mean();
  }
}

TEST(NativeReconstruction, WithoutHalvesOnlyRebuilds) {
  RecordedTree t = synthetic::Record({.radiance = Sky, .records = 300});
  t.masses.halves = {};
  EXPECT_TRUE(SameNodes(ReconstructNative(t.masses, 0.01, 20), synthetic::Plain(t.masses, 0.01, 20)));
}

TEST(NativeReconstruction, LogarithmAndExponentialAreGoodEnough) {
  for (double x = 1e-3; x < 1e30; x *= 1.7) {
    const float f = static_cast<float>(x);
    EXPECT_NEAR(directional::Log(directional::Broadcast(f))[3], std::log(f), 1e-6 * std::max(1.0f, std::log(f)));
  }
  for (double x = 0; x < 80; x = x * 1.3 + 0.01) {
    const float f = static_cast<float>(-x);
    EXPECT_NEAR(directional::Exp(directional::Broadcast(f))[5] / std::exp(f), 1, 1e-5);
  }
  EXPECT_LT(directional::Exp(directional::Broadcast(-1e30f))[0], 1e-34);
}

}  // namespace
}  // namespace lodestar
