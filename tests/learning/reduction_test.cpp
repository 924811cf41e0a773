#include "core/learning/reduction.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/learning/contribution.h"
#include "core/learning/loop.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

using Outcome = RoundReduction::Outcome;

Contribution TileOnly(uint32_t first, uint32_t end, uint64_t paths_per_unit = 1) {
  Contribution contribution;
  for (uint32_t unit = first; unit < end; ++unit)
    contribution.tiles.push_back({unit, std::vector<PixelSum>(TileGrid::kTileSize)});
  contribution.paths = paths_per_unit * (end - first);
  return contribution;
}

// A round of `units` tiles in a row, of a job that learns nothing.
class ReductionTest : public ::testing::Test {
 protected:
  RoundReduction NewReduction(uint32_t units) {
    units_ = units;
    return {*method_, method_->Initial(), TileGrid(units * TileGrid::kTileSize, 1), {0, 0, 0, 1, units, false}};
  }
  Outcome Commit(RoundReduction& reduction, TreeNode node, uint64_t paths_per_unit = 1) const {
    return reduction.Commit({&node, 1},
                            SerializeContribution(TileOnly(node.first(), node.end(units_), paths_per_unit)));
  }
  uint32_t units_ = 0;
  const std::unique_ptr<Method> method_ = MakeMethod(test::SyntheticJob("path", 1), test::SyntheticSurvey());
};

TEST_F(ReductionTest, CoversInAnyOrder) {
  RoundReduction reduction = NewReduction(8);
  EXPECT_EQ(Commit(reduction, {0, 1}), Outcome::kCommitted);
  EXPECT_EQ(reduction.Nodes(), (std::vector<TreeNode>{{0, 1}}));
  EXPECT_EQ(Commit(reduction, {0, 0}), Outcome::kCommitted);
  EXPECT_EQ(reduction.Nodes(), (std::vector<TreeNode>{{1, 0}}));
  EXPECT_EQ(Commit(reduction, {2, 1}), Outcome::kCommitted);
  EXPECT_EQ(reduction.Nodes(), (std::vector<TreeNode>{{1, 0}, {2, 1}}));
  EXPECT_EQ(reduction.committed_units(), 6u);
  EXPECT_EQ(reduction.merged().paths, 6u);
  EXPECT_FALSE(reduction.Complete());
  EXPECT_EQ(Commit(reduction, {1, 1}), Outcome::kCommitted);
  ASSERT_TRUE(reduction.Complete());
  EXPECT_EQ(reduction.Nodes(), (std::vector<TreeNode>{{3, 0}}));
  const Contribution root = reduction.Take();
  ASSERT_EQ(root.tiles.size(), 8u);
  for (uint32_t i = 0; i < 8; ++i) EXPECT_EQ(root.tiles[i].tile, i);
}

TEST_F(ReductionTest, TheEdgeNeedsNoSibling) {
  RoundReduction reduction = NewReduction(5);  // the block of unit 4 is cut at every level
  EXPECT_EQ(Commit(reduction, {0, 4}), Outcome::kCommitted);
  EXPECT_EQ(reduction.Nodes(), (std::vector<TreeNode>{{2, 1}}));
  EXPECT_TRUE(reduction.Covered({1, 2}));
  EXPECT_EQ(Commit(reduction, {2, 0}), Outcome::kCommitted);
  EXPECT_TRUE(reduction.Complete());
}

TEST_F(ReductionTest, OneUnit) {
  RoundReduction reduction = NewReduction(1);
  EXPECT_EQ(Commit(reduction, {0, 0}), Outcome::kCommitted);
  EXPECT_TRUE(reduction.Complete());
  EXPECT_EQ(Commit(reduction, {0, 0}), Outcome::kCovered);
}

TEST_F(ReductionTest, CoveredNodesAreDropped) {
  RoundReduction reduction = NewReduction(16);
  Commit(reduction, {2, 1}, 1);
  for (const TreeNode node : {TreeNode{2, 1}, TreeNode{1, 2}, TreeNode{0, 7}}) {
    EXPECT_TRUE(reduction.Covered(node));
    EXPECT_EQ(Commit(reduction, node, 100), Outcome::kCovered);
  }
  EXPECT_EQ(reduction.merged().paths, 4u);
  EXPECT_FALSE(reduction.Covered({3, 0}));
  EXPECT_FALSE(reduction.Covered({2, 0}));
}

TEST_F(ReductionTest, WhatOverlapsIsDroppedAndItsRestStaysMissing) {
  RoundReduction reduction = NewReduction(16);
  Commit(reduction, {0, 0}, 5);
  Commit(reduction, {1, 1}, 5);
  EXPECT_EQ(Commit(reduction, {3, 0}, 1), Outcome::kCovered);
  EXPECT_EQ(reduction.committed_units(), 3u);
  EXPECT_EQ(reduction.merged().paths, 15u);
  EXPECT_EQ(reduction.Missing(2), (std::vector<TreeNode>{{0, 1}, {2, 1}, {2, 2}, {2, 3}}));
}

TEST_F(ReductionTest, MissingAreMaximalAlignedNodes) {
  RoundReduction reduction = NewReduction(11);
  EXPECT_EQ(reduction.Missing(10), (std::vector<TreeNode>{{4, 0}}));
  EXPECT_EQ(reduction.Missing(2), (std::vector<TreeNode>{{2, 0}, {2, 1}, {2, 2}}));
  EXPECT_EQ(reduction.Missing(0).size(), 11u);
  Commit(reduction, {0, 5});
  Commit(reduction, {0, 10});
  EXPECT_EQ(reduction.Missing(10), (std::vector<TreeNode>{{2, 0}, {0, 4}, {1, 3}, {1, 4}}));
  EXPECT_EQ(reduction.Missing(1), (std::vector<TreeNode>{{1, 0}, {1, 1}, {0, 4}, {1, 3}, {1, 4}}));
  for (const TreeNode node : reduction.Missing(1)) Commit(reduction, node);
  EXPECT_TRUE(reduction.Complete());
  EXPECT_TRUE(reduction.Missing(3).empty());
}

TEST_F(ReductionTest, NodesFromOutsideAreChecked) {
  RoundReduction reduction = NewReduction(11);
  for (const TreeNode node : {TreeNode{5, 0}, TreeNode{0, 11}, TreeNode{2, 3}, TreeNode{200, 0}, TreeNode{1, ~0u}}) {
    EXPECT_THROW(reduction.Commit({&node, 1}, {}), Error) << node.ToString();
  }
  EXPECT_EQ(reduction.committed_units(), 0u);
}

// Statistics that end early must not leave half of themselves behind: the same nodes come again from another worker.
TEST(Reduction, DamagedStatisticsLeaveNothingBehind) {
  const Loop loop(test::SyntheticJob("sdtree", 8), test::SyntheticSurvey(90, 50));
  const TileGrid grid(90, 50);
  const Round round{1, 0, 1, 2, grid.tile_count(), true};
  const TreeNode root = TreeNode::Root(round.unit_count);
  Contribution whole;
  for (uint32_t unit = 0; unit < round.unit_count; ++unit)
    whole.Merge(test::RenderUnit(loop.job(), loop.method(), loop.state(), grid, round, unit));
  class Cut final : public Statistics {
   public:
    explicit Cut(Bytes bytes) : bytes_(std::move(bytes)) {}
    void Merge(const Statistics&) override {}
    Bytes Serialize() const override { return bytes_; }
    void MergeSerialized(std::string_view) override {}

   private:
    Bytes bytes_;
  };
  const Bytes sound = SerializeContribution(whole), statistics = whole.statistics->Serialize();
  RoundReduction reduction(loop.method(), loop.state(), grid, round);
  for (const size_t size : {size_t{0}, statistics.size() / 2, statistics.size() - 1}) {
    whole.statistics = std::make_unique<Cut>(statistics.substr(0, size));
    EXPECT_THROW(reduction.Commit({&root, 1}, SerializeContribution(whole)), Error) << size;
    EXPECT_TRUE(reduction.Nodes().empty());
  }
  EXPECT_EQ(reduction.Commit({&root, 1}, sound), Outcome::kCommitted);
  EXPECT_TRUE(SerializeContribution(reduction.Take()) == sound);
}

// A worker that sends pictures alone would leave the state to learn from the others' units.
TEST(Reduction, StatisticsMayNotBeMissing) {
  const Loop loop(test::SyntheticJob("sdtree", 8), test::SyntheticSurvey(90, 50));
  const TileGrid grid(90, 50);
  const Round round{1, 0, 1, 2, grid.tile_count(), true};
  RoundReduction reduction(loop.method(), loop.state(), grid, round);
  const auto commit = [&](uint32_t unit, bool with_statistics) {
    Contribution part = test::RenderUnit(loop.job(), loop.method(), loop.state(), grid, round, unit);
    if (!with_statistics) part.statistics.reset();
    const TreeNode node{0, unit};
    return reduction.Commit({&node, 1}, SerializeContribution(part));
  };
  for (const uint32_t unit : {0u, 1u}) {  // without others' and with them
    try {
      commit(unit, false);
      ADD_FAILURE() << "was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kCorrupt);
    }
    EXPECT_EQ(reduction.committed_units(), unit);
    EXPECT_EQ(commit(unit, true), Outcome::kCommitted);
  }
  // A method that learns nothing has none in a round that records either.
  const auto path = MakeMethod(test::SyntheticJob("path", 1), test::SyntheticSurvey());
  RoundReduction plain(*path, path->Initial(), TileGrid(TileGrid::kTileSize, 1), {0, 0, 0, 1, 1, true});
  const TreeNode only{0, 0};
  EXPECT_EQ(plain.Commit({&only, 1}, SerializeContribution(TileOnly(0, 1))), Outcome::kCommitted);
}

// What a checkpoint holds of a round: several nodes in one contribution.
TEST(Reduction, GoesOnFromTheBytesOfSeveralNodes) {
  const Loop loop(test::SyntheticJob("sdtree", 8), test::SyntheticSurvey(90, 50));
  const TileGrid grid(90, 50);
  const Round round{1, 0, 1, 2, grid.tile_count(), true};
  const auto render = [&](TreeNode node) {
    Contribution sum;
    for (uint32_t unit = node.first(); unit < node.end(round.unit_count); ++unit)
      sum.Merge(test::RenderUnit(loop.job(), loop.method(), loop.state(), grid, round, unit));
    return SerializeContribution(sum);
  };
  RoundReduction first(loop.method(), loop.state(), grid, round), second(loop.method(), loop.state(), grid, round);
  for (const TreeNode node : {TreeNode{0, 5}, TreeNode{1, 0}}) first.Commit({&node, 1}, render(node));
  const Bytes merged = SerializeContribution(first.merged());
  EXPECT_THROW(second.Commit(std::vector<TreeNode>{{0, 5}, {1, 0}}, merged), Error) << "not ascending";
  ASSERT_EQ(second.Commit(first.Nodes(), merged), Outcome::kCommitted);
  EXPECT_EQ(second.Nodes(), first.Nodes());
  for (RoundReduction* reduction : {&first, &second}) {
    for (const TreeNode node : reduction->Missing(1)) reduction->Commit({&node, 1}, render(node));
  }
  EXPECT_TRUE(SerializeContribution(first.Take()) == SerializeContribution(second.Take()));
}

TEST(Reduction, MergesEmptySingleAndUnequalParts) {
  Contribution empty, one = TileOnly(3, 4), many = TileOnly(100, 1100);
  empty.Merge({});
  EXPECT_TRUE(empty.tiles.empty());
  empty.Merge(std::move(many));
  empty.Merge(std::move(one));
  empty.Merge({});
  ASSERT_EQ(empty.tiles.size(), 1001u);
  EXPECT_EQ(empty.tiles[0].tile, 3u);
  EXPECT_EQ(empty.tiles[1000].tile, 1099u);
  EXPECT_EQ(empty.paths, 1001u);
  EXPECT_EQ(empty.statistics, nullptr);
}

TEST(ReductionDeathTest, TheSameUnitTwiceIsABug) {
  Contribution a = TileOnly(0, 2), b = TileOnly(1, 2);
  EXPECT_DEATH(a.Merge(std::move(b)), "");
}

// Any order and partition of real statistics gives the same bytes.
TEST(Reduction, BytesDoNotDependOnOrderOrPartition) {
  const Survey survey = test::SyntheticSurvey(90, 50);
  const JobSpec job = test::SyntheticJob("sdtree", 8);
  const Loop loop(job, survey);
  const TileGrid grid(90, 50);
  const Round round{1, 0, 1, 2, grid.tile_count(), true};
  const StopToken never;
  std::optional<Bytes> expected;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    test::SyntheticExecutor executor(loop, {.shuffle = seed, .detours = seed % 3 == 2});
    const auto contribution = executor.Execute(loop.state(), round, never);
    const Bytes bytes = SerializeContribution(*contribution);
    if (!expected) expected = bytes;
    EXPECT_TRUE(bytes == *expected) << seed;
  }
  EXPECT_GT(expected->size(), 90 * 50 * sizeof(PixelSum) + 100);
}

}  // namespace
}  // namespace lodestar
