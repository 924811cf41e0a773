#include "core/learning/round.h"

#include <gtest/gtest.h>

#include "core/learning/loop.h"

namespace lodestar {
namespace {

TEST(TreeNode, RootIsTheSmallestThatCovers) {
  EXPECT_EQ(TreeNode::Root(1), (TreeNode{0, 0}));
  EXPECT_EQ(TreeNode::Root(2), (TreeNode{1, 0}));
  EXPECT_EQ(TreeNode::Root(5), (TreeNode{3, 0}));
  EXPECT_EQ(TreeNode::Root(8), (TreeNode{3, 0}));
  EXPECT_EQ(TreeNode::Root(9), (TreeNode{4, 0}));
  EXPECT_EQ(TreeNode::Root(~0u), (TreeNode{32, 0}));
}

TEST(TreeNode, BlocksAreCutAtTheLastUnit) {
  const TreeNode node{2, 1};
  EXPECT_EQ(node.first(), 4u);
  EXPECT_EQ(node.end(100), 8u);
  EXPECT_EQ(node.end(6), 6u);
  EXPECT_EQ(TreeNode::Root(~0u).end(~0u), ~0u);
  EXPECT_EQ((TreeNode{31, 1}).end(~0u), ~0u);
}

TEST(TreeNode, Family) {
  const TreeNode node{2, 5};
  EXPECT_EQ(node.Child(1).Parent(), node);
  EXPECT_EQ(node.Child(0).first(), node.first());
  EXPECT_TRUE(node.Covers(node));
  EXPECT_TRUE(node.Covers(node.Child(1).Child(0)));
  EXPECT_FALSE(node.Covers(node.Parent()));
  EXPECT_FALSE(node.Covers({2, 4}));
  EXPECT_FALSE(node.Covers({0, 24}));
}

TEST(TreeNode, ValidityOfNodesFromOutside) {
  EXPECT_TRUE((TreeNode{0, 4}).ValidIn(5));
  EXPECT_FALSE((TreeNode{0, 5}).ValidIn(5));
  EXPECT_TRUE((TreeNode{3, 0}).ValidIn(5));
  EXPECT_FALSE((TreeNode{4, 0}).ValidIn(5));
  EXPECT_FALSE((TreeNode{1, 3}).ValidIn(5));
  EXPECT_FALSE((TreeNode{77, 0}).ValidIn(5));
  EXPECT_FALSE((TreeNode{2, ~0u}).ValidIn(5));
  EXPECT_FALSE((TreeNode{0, 0}).ValidIn(0));
}

TEST(PassesPerRound, AboutAMillionSamplesTwoWhereTheyAreRecorded) {
  struct Case {
    uint32_t width, height, passes, recorded;
  };
  for (const Case& c : {Case{1, 1, 64, 64}, Case{128, 128, 64, 64}, Case{320, 180, 16, 32}, Case{640, 360, 4, 8},
                        Case{1024, 1024, 1, 2}, Case{8192, 8192, 1, 1}}) {
    EXPECT_EQ(PassesPerRound(c.width, c.height, false), c.passes) << c.width << " x " << c.height;
    EXPECT_EQ(PassesPerRound(c.width, c.height, true), c.recorded) << c.width << " x " << c.height;
  }
}

}  // namespace
}  // namespace lodestar
