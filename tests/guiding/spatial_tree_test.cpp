#include "core/guiding/spatial_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

// A random full binary tree, as depths in depth-first order.
void RandomDepths(uint64_t& rng, int depth, int max_depth, std::vector<uint8_t>& out) {
  if (depth < max_depth && (depth < 4 || synthetic::Unit(rng) < 0.6f)) {
    RandomDepths(rng, depth + 1, max_depth, out);
    RandomDepths(rng, depth + 1, max_depth, out);
  } else {
    out.push_back(static_cast<uint8_t>(depth));
  }
}

TEST(SpatialTree, EveryPointIsInItsLeaf) {
  uint64_t rng = 2;
  std::vector<uint8_t> depths;
  RandomDepths(rng, 0, 22, depths);
  const auto tree = SpatialTree::FromDepths({-1, -2, -3}, 4, depths);
  ASSERT_TRUE(tree.has_value());
  ASSERT_EQ(tree->leaf_count(), depths.size());
  double volume = 0;
  for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf) {
    const Vec3 d = tree->LeafBounds(leaf).Diagonal();
    volume += static_cast<double>(d.x) * d.y * d.z;
    EXPECT_EQ(tree->LeafAt(tree->LeafBounds(leaf).Center()), leaf);
  }
  EXPECT_NEAR(volume, 64, 1e-4);
  for (int i = 0; i < 100000; ++i) {
    const Vec3 p = Vec3{-1, -2, -3} + synthetic::Unit3(rng) * 4;
    const Bounds3 box = tree->LeafBounds(tree->LeafAt(p));
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(p[axis], box.min[axis] - 1e-5f);
      ASSERT_LE(p[axis], box.max[axis] + 1e-5f);
    }
  }
}

TEST(SpatialTree, AxesTakeTurns) {
  const auto tree = SpatialTree::FromDepths({0, 0, 0}, 1, std::vector<uint8_t>{1, 2, 3, 3});
  ASSERT_TRUE(tree.has_value());
  EXPECT_EQ(tree->LeafAt(Vec3{0.4f, 0.9f, 0.9f}), 0u);
  EXPECT_EQ(tree->LeafAt(Vec3{0.6f, 0.4f, 0.9f}), 1u);
  EXPECT_EQ(tree->LeafAt(Vec3{0.6f, 0.6f, 0.4f}), 2u);
  EXPECT_EQ(tree->LeafAt(Vec3{0.6f, 0.6f, 0.6f}), 3u);
}

TEST(SpatialTree, BordersOutsideAndNanHaveALeaf) {
  const auto tree = SpatialTree::FromDepths({0, 0, 0}, 1, std::vector<uint8_t>{3, 3, 3, 3, 3, 3, 3, 3});
  ASSERT_TRUE(tree.has_value());
  EXPECT_EQ(tree->LeafAt(Vec3{0, 0, 0}), 0u);
  EXPECT_EQ(tree->LeafAt(Vec3{1, 1, 1}), 7u);
  EXPECT_EQ(tree->LeafAt(Vec3{0.5f, 0.5f, 0.5f}), 7u);
  EXPECT_EQ(tree->LeafAt(Vec3{-1e30f, -kInfinity, -5}), 0u);
  EXPECT_EQ(tree->LeafAt(Vec3{1e30f, kInfinity, 5}), 7u);
  EXPECT_LT(tree->LeafAt(Vec3{std::nanf(""), 0.2f, 0.2f}), 8u);
}

TEST(SpatialTree, DepthsThatAreNoTreeAreRefused) {
  using Depths = std::vector<uint8_t>;
  for (const Depths& depths : {Depths{}, {1}, {0, 0}, {1, 1, 1}, {2, 2}, {1, 2}, {2, 1, 1}, {64}, {255, 1}}) {
    EXPECT_FALSE(SpatialTree::FromDepths({0, 0, 0}, 1, depths).has_value());
  }
  Depths deepest;  // one leaf at each depth, the last two at the maximum
  for (int d = 1; d <= SpatialTree::kMaxDepth; ++d) deepest.push_back(static_cast<uint8_t>(d));
  deepest.push_back(SpatialTree::kMaxDepth);
  EXPECT_TRUE(SpatialTree::FromDepths({0, 0, 0}, 1, deepest).has_value());
  deepest.back() = SpatialTree::kMaxDepth + 1;
  EXPECT_FALSE(SpatialTree::FromDepths({0, 0, 0}, 1, deepest).has_value());
}

TEST(SpatialTree, OverlapsShareOutTheBox) {
  uint64_t rng = 4;
  std::vector<uint8_t> depths;
  RandomDepths(rng, 0, 14, depths);
  const auto tree = SpatialTree::FromDepths({0, 0, 0}, 1, depths);
  ASSERT_TRUE(tree.has_value());
  for (int i = 0; i < 500; ++i) {
    const uint32_t leaf = tree->LeafAt(synthetic::Unit3(rng));
    const SpatialTree::Cell& cell = tree->cell(leaf);
    const SpatialTree::Coordinates size = {cell.Size(0), cell.Size(1), cell.Size(2)};
    double sum = 0;
    tree->ForOverlaps(cell.lower, size, [&](uint32_t visited, double share) {
      EXPECT_EQ(visited, leaf);
      sum += share;
    });
    ASSERT_NEAR(sum, 1, 1e-12);
  }
}

}  // namespace
}  // namespace lodestar
