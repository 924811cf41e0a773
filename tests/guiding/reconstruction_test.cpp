#include "core/guiding/reconstruction.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/guiding/reconstruction_blur.h"
#include "tests/guiding/recorded_tree.h"

namespace lodestar {
namespace {

using directional::CellMasses;
using synthetic::SameNodes;

// The document's algorithm as it is told, without any of its or our shortcuts: flat arrays, a two-dimensional kernel,
// every layer expanded to the finest. Returns the matrix that is rebuilt, row by row.
std::vector<double> NaiveDense(const CellMasses& masses, int tree_depth, double sigma) {
  const auto mass_below = [&](auto& self, uint32_t slot) -> double {
    const uint32_t child = masses.nodes[slot / 4].child[slot % 4];
    if (child == 0) return masses.total[slot];
    double sum = 0;
    for (uint32_t c = 0; c < 4; ++c) sum += self(self, child * 4 + c);
    return sum;
  };
  const auto levels_below = [&](auto& self, uint32_t slot) -> int {
    const uint32_t child = masses.nodes[slot / 4].child[slot % 4];
    if (child == 0) return 0;
    int deepest = 0;
    for (uint32_t c = 0; c < 4; ++c) deepest = std::max(deepest, 1 + self(self, child * 4 + c));
    return deepest;
  };
  const int n = 1 << tree_depth;
  std::vector<double> result(size_t(n) * n, 0.0);
  for (int layer = 6; layer <= tree_depth; ++layer) {
    const int size = 1 << layer;
    std::vector<double> flat(size_t(size) * size), blurred(flat.size(), 0.0);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        uint32_t node = 0, slot = 0;
        int depth = 0;
        for (;;) {
          ++depth;
          slot = node * 4 + ((x >> (layer - depth)) & 1) + 2 * ((y >> (layer - depth)) & 1);
          node = masses.nodes[slot / 4].child[slot % 4];
          if (node == 0 || depth == layer) break;
        }
        flat[size_t(y) * size + x] = mass_below(mass_below, slot) * std::pow(0.25, layer - depth) *
                                     std::pow(0.25, levels_below(levels_below, slot));
      }
    }
    double norm = 0;
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j) norm += std::exp(-(i * i + j * j) / (2 * sigma * sigma));
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        for (int i = -3; i <= 3; ++i) {
          for (int j = -3; j <= 3; ++j) {
            if (y + i < 0 || y + i >= size || x + j < 0 || x + j >= size) continue;
            blurred[size_t(y) * size + x] +=
                flat[size_t(y + i) * size + x + j] * std::exp(-(i * i + j * j) / (2 * sigma * sigma)) / norm;
          }
        }
      }
    }
    const int expand = tree_depth - layer;
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        double& to = result[size_t(y) * n + x];
        to = std::max(to, blurred[size_t(y >> expand) * size + (x >> expand)] * std::pow(0.25, expand));
      }
    }
  }
  return result;
}

TEST(DenseReconstruction, FollowsTheDocument) {
  for (const int max_depth : {6, 7, 8}) {
    const synthetic::RecordedTree t = synthetic::Record({.radiance =
                                                             [](Vec3 w) {
                                                               return synthetic::MovingLobes({0.3f, 0.6f, 0.2f}, w);
                                                             },
                                                         .max_depth = max_depth});
    ASSERT_EQ(t.tree.depth, max_depth);
    const std::vector<double> expected = NaiveDense(t.masses, t.tree.depth, 0.7);
    double total = 0;
    for (double e : expected) total += e;
    const directional::Tree tree = directional::ReconstructDense(t.masses, 0.7f, 0.002, 20);
    // Every cell of the result holds the sum of the elements it covers (or its part of one), up to the integers of its
    // nodes.
    const int n = 1 << t.tree.depth;
    const auto cell_at = [&](int x, int y) {
      return directional::Locate(tree.nodes.data(), uint32_t(x) << (24 - t.tree.depth),
                                 uint32_t(y) << (24 - t.tree.depth));
    };
    std::vector<double> mass(tree.nodes.size() * 4, 0.0);
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) mass[cell_at(x, y).slot] += expected[size_t(y) * n + x] / total;
    }
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const auto cell = cell_at(x, y);
        const double p = cell.density / kUniformSpherePdf * std::pow(0.25, std::min(cell.depth, t.tree.depth));
        ASSERT_NEAR(p, mass[cell.slot], 0.02 * mass[cell.slot] + 3e-5);
      }
    }
  }
}

double Lamp(Vec3 w) {
  return 0.01 + 100 * std::exp(2000 * (static_cast<double>(Dot(Normalize(Vec3{1, 2, 1}), w)) - 1));
}

// Masked tiles hold what they would if they were blurred, up to the kernel's rounding.
TEST(DenseReconstruction, MasksOnlyWhatTheBlurWouldKeep) {
  constexpr int kDepth = 7, kSize = 1 << kDepth, kTiles = kSize / directional::kBlurTile;
  directional::FramedMatrix matrix(kDepth);
  uint64_t rng = 5;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) matrix.Row(y)[x] = x < 80 && y < 80 ? 3 : synthetic::Unit(rng);
  }
  directional::SameTiles none(kTiles * kTiles, 0), same = none;
  for (int ty = 1; ty < 4; ++ty) std::fill_n(&same[ty * kTiles + 1], 3, 1);  // 16 to 63: the border and 80 are 3 away
  std::vector<float> masked(kSize * kSize), all(masked.size());
  const auto kernel = directional::Gaussian(0.9f);
  directional::Blur(matrix, same, kernel, masked.data());
  directional::Blur(matrix, none, kernel, all.data());
  for (size_t i = 0; i < all.size(); ++i) ASSERT_NEAR(masked[i], all[i], 1e-6 * 3);
  EXPECT_LT(all[0], 2);  // zeros outside
}

TEST(DenseReconstruction, OnlyRebuildsTreesOutsideItsDepths) {
  for (const int depth : {5, 14}) {
    synthetic::RecordedTree t;
    t.tree = {{DirectionalNode{}}, 1};
    for (int round = 0; round < 4; ++round) {
      t.masses = {t.tree.nodes.data(), static_cast<uint32_t>(t.tree.nodes.size()), {}, {}};
      t.masses.total.assign(t.tree.nodes.size() * 4, 1e-4);
      for (uint32_t node = 0; node < t.masses.node_count; ++node) {
        for (uint32_t c = 0; c < 4; ++c) t.masses.total[node * 4 + c] *= t.masses.nodes[node].child[c] == 0;
      }
      t.masses.total[directional::Locate(t.masses.nodes, Vec2{0.3f, 0.7f}).slot] = 1;
      if (round < 3) t.tree = synthetic::Plain(t.masses, 0.01, depth);
      t.masses.nodes = t.tree.nodes.data();
    }
    ASSERT_EQ(t.tree.depth, depth == 5 ? 5 : 13);
    EXPECT_TRUE(
        SameNodes(directional::ReconstructDense(t.masses, 0.8f, 0.01, 20), synthetic::Plain(t.masses, 0.01, 20)));
  }
}

TEST(Reconstruction, KeepsToTheLimitsAndDoesNotDependOnScale) {
  const synthetic::RecordedTree t = synthetic::Record({.radiance = Lamp, .records = 2000, .max_depth = 8});
  CellMasses scaled = t.masses;
  for (double& v : scaled.total) v = std::ldexp(v, 40);
  for (auto& half : scaled.halves)
    for (double& v : half) v = std::ldexp(v, 40);
  for (const bool dense : {false, true}) {
    const auto reconstruct = [&](const CellMasses& m, double threshold, int depth) {
      return dense ? directional::ReconstructDense(m, 0.8f, threshold, depth)
                   : directional::ReconstructNative(m, threshold, depth);
    };
    for (const int depth : {1, 6, 20}) EXPECT_LE(reconstruct(t.masses, 1e-4, depth).depth, depth);
    const directional::Tree finest = reconstruct(t.masses, 1e-9, 20);
    EXPECT_LE(finest.nodes.size(), directional::kMaxNodes);
    EXPECT_GT(finest.nodes.size(), directional::kMaxNodes / 2);  // the limit was met
    EXPECT_TRUE(SameNodes(reconstruct(t.masses, 0.01, 20), reconstruct(scaled, 0.01, 20)));
    EXPECT_FALSE(SameNodes(reconstruct(t.masses, 0.01, 20), synthetic::Plain(t.masses, 0.01, 20)));
  }
}

TEST(DenseReconstruction, KeepsToTheWorkload) {
  // Elements of a tree of depth 6, 7, 8: 4096, 20480, 86016.
  const std::vector<int> depths = {8, 5, 11, 6, 10, 7, 12, 6};
  const std::vector<uint8_t> all = {1, 0, 0, 1, 1, 1, 0, 1};
  EXPECT_EQ(directional::WithinWorkload(depths, 0), all);
  // A thousand trees of depth 8 are 8.6e7 elements: 174 fit at first, all from the third iteration on.
  std::vector<int> many(1000, 8);
  many.push_back(6);
  const auto taken = [&](int iteration) {
    const auto w = directional::WithinWorkload(many, iteration);
    EXPECT_EQ(w.back(), 1);
    return std::count(w.begin(), w.end(), 1);
  };
  EXPECT_EQ(taken(0), 1 + static_cast<int>((1.5e7 - 4096) / 86016));
  EXPECT_EQ(taken(3), 1001);
}

}  // namespace
}  // namespace lodestar
