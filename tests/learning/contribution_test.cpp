#include "core/learning/contribution.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

// A round of 3 x 2 tiles of a job that learns, and one node of it.
class ContributionTest : public ::testing::Test {
 protected:
  ContributionTest()
      : job_(test::SyntheticJob("sdtree", 10)),
        method_(MakeMethod(job_, test::SyntheticSurvey())),
        state_(method_->Initial()) {}

  Contribution Render(TreeNode node) const {
    Contribution sum;
    for (uint32_t unit = node.first(); unit < node.end(round_.unit_count); ++unit) {
      sum.Merge(test::RenderUnit(job_, *method_, state_, grid_, round_, unit));
    }
    return sum;
  }
  Contribution Parse(std::string_view bytes, TreeNode node) const {
    ReceivedContribution received = ReadContribution(grid_, round_, {&node, 1}, bytes);
    if (received.statistics) AddStatistics(*method_, state_, *received.statistics, &received.rest.statistics);
    return std::move(received.rest);
  }
  std::string Refusal(std::string_view bytes, TreeNode node) const {
    try {
      Parse(bytes, node);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kCorrupt) << error.what();
      return error.what();
    }
    return "accepted";
  }

  const JobSpec job_;
  const std::unique_ptr<Method> method_;
  const std::shared_ptr<const State> state_;
  const TileGrid grid_{40, 24};
  Round round_{1, 0, 1, 2, 6, true};
  const TreeNode node_{1, 1};
};

TEST_F(ContributionTest, RoundTripKeepsEveryBit) {
  for (const TreeNode node : {node_, TreeNode{0, 5}, TreeNode{3, 0}, TreeNode{2, 1}}) {
    const Bytes bytes = SerializeContribution(Render(node));
    const Contribution back = Parse(bytes, node);
    EXPECT_TRUE(SerializeContribution(back) == bytes);
    EXPECT_EQ(back.tiles.size(), node.end(6) - node.first());
    EXPECT_NE(back.statistics, nullptr);
  }
}

TEST_F(ContributionTest, DamageIsRefused) {
  const Bytes bytes = SerializeContribution(Render(node_));
  for (size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 61)
    EXPECT_THROW(Parse(std::string_view(bytes).substr(0, size), node_), Error) << size;
  for (size_t i = 0; i < bytes.size(); i += i < 200 ? 1 : 37) {
    Bytes damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    EXPECT_THROW(Parse(damaged, node_), Error) << i;
  }
}

// Bytes with a right checksum around wrong content: what a faulty or hostile worker could send.
TEST_F(ContributionTest, ForeignContentIsRefused) {
  const TreeNode sibling{1, 0};
  EXPECT_NE(Refusal(SerializeContribution(Render(sibling)), node_).find("holds tile 0 where tile 2 belongs"),
            std::string::npos);
  EXPECT_NE(Refusal(SerializeContribution(Render({2, 0})), node_).find("does not hold the 2 tiles of its nodes"),
            std::string::npos);
  EXPECT_NE(Refusal(SerializeContribution(Render(node_)), {4, 0}).find("node that does not exist"), std::string::npos);

  Contribution wrong = Render(node_);
  wrong.tiles[1].tile = 2;
  EXPECT_NE(Refusal(SerializeContribution(wrong), node_).find("holds tile 2 where tile 3 belongs"), std::string::npos);

  wrong = Render(node_);
  wrong.tiles[0].pixels.pop_back();
  EXPECT_NE(Refusal(SerializeContribution(wrong), node_).find("pixels in tile 2, which has"), std::string::npos);
}

TEST_F(ContributionTest, NonFinitePixelsAreRefused) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Contribution poisoned = Render(node_);
    poisoned.tiles[0].pixels[9].g = bad;  // tile 2 begins at x 32, and is 8 wide
    EXPECT_NE(Refusal(SerializeContribution(poisoned), node_).find("not finite at x 33, y 1"), std::string::npos);
  }
  Contribution negative = Render(node_);
  negative.tiles[1].pixels[0].luminance_squared = -1;
  EXPECT_NE(Refusal(SerializeContribution(negative), node_), "accepted");
}

TEST_F(ContributionTest, StatisticsOnlyWhereSomethingIsLearned) {
  const Bytes bytes = SerializeContribution(Render(node_));
  round_.record = false;
  EXPECT_NE(Refusal(bytes, node_).find("nothing is learned from its round"), std::string::npos);
  EXPECT_EQ(Parse(SerializeContribution(Render(node_)), node_).statistics, nullptr);
}

TEST_F(ContributionTest, StatisticsOfAnotherStateAreRefused) {
  // The next state's statistics do not fit this one.
  const Contribution learned = Render({3, 0});
  const Image image{1, 1, {Rgb(1)}, {0}};
  const auto next =
      method_->Advance(state_, {.statistics = learned.statistics.get(), .iteration = 1, .passes = 2, .image = &image});
  ASSERT_NE(next->Serialize(), state_->Serialize());
  Contribution foreign;
  for (const uint32_t unit : {2u, 3u}) foreign.Merge(test::RenderUnit(job_, *method_, next, grid_, round_, unit));
  EXPECT_THROW(Parse(SerializeContribution(foreign), node_), Error);
}

TEST_F(ContributionTest, AnotherImageSizeIsRefused) {
  const Bytes bytes = SerializeContribution(Render(node_));
  EXPECT_THROW(ReadContribution(TileGrid(41, 25), round_, {&node_, 1}, bytes), Error);
  EXPECT_THROW(ReadContribution(TileGrid(400, 240), round_, {&node_, 1}, bytes), Error);
}

}  // namespace
}  // namespace lodestar
