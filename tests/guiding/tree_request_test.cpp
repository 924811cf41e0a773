// Trees that another process makes are those of this one, to the bit; and what is no request or answer is refused.
#include "core/guiding/tree_request.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/guiding/sd_tree_advance.h"
#include "tests/guiding/recorded_tree.h"
#include "tests/support/resealed.h"

namespace lodestar {
namespace {

using Reconstruction = SdTreeOptions::Reconstruction;
using synthetic::SameNodes;

constexpr Reconstruction kAll[] = {Reconstruction::kNone, Reconstruction::kDense, Reconstruction::kNative,
                                   Reconstruction::kDenseUnlimited};

synthetic::RecordedTree Lobe(uint64_t seed, int records) {
  synthetic::Recording recording;
  recording.radiance = [](Vec3 w) { return 0.01 + std::exp(40.0 * (w.z * 0.8 + w.x * 0.6 - 1)); };
  recording.records = records;
  recording.second_moment = true;
  recording.seed = seed;
  return synthetic::Record(recording);
}

TEST(TreeRequest, TreesComeBackAsTheyAreMadeHere) {
  std::vector<synthetic::RecordedTree> recorded;
  for (const int records : {200, 3000, 20000}) recorded.push_back(Lobe(recorded.size() + 1, records));
  for (const DenseRecipe& recipe : {DenseRecipe{0.8f, 0.005, 15}, {1.5f, 0.02, 15}, {0.5f, 0.001, 4}}) {
    TreeRequest request(recipe);
    for (uint32_t i = 0; i < 3; ++i) request.Add(10 * i + 1, recorded[i].masses);
    const auto back = ReadTreeAnswer(AnswerTreeRequest(request.Take()), 22, 15);
    ASSERT_EQ(back.size(), 3u);
    for (uint32_t i = 0; i < 3; ++i) {
      const directional::Tree here =
          directional::ReconstructDense(recorded[i].masses, recipe.sigma, recipe.flux_threshold, recipe.max_depth);
      EXPECT_EQ(back[i].place, 10 * i + 1);
      EXPECT_EQ(back[i].tree.depth, here.depth);
      EXPECT_TRUE(SameNodes(back[i].tree, here)) << "tree " << i << ", sigma " << recipe.sigma;
    }
  }
  EXPECT_TRUE(TreeRequest(DenseRecipe()).Take().empty());
}

// Everything that can be left to others is, by way of bytes.
class Elsewhere final : public ShardRunner {
 public:
  void Run(ShardedWork& work) override {
    for (uint32_t shard = work.count(); shard-- > 0;) {
      const Bytes request = work.Describe(shard);
      if (request.empty()) {
        work.DoHere(shard);
        ++here;
      } else {
        work.Accept(shard, AnswerTreeRequest(request));
        ++elsewhere;
      }
    }
  }
  int here = 0, elsewhere = 0;
};

TEST(TreeRequest, AnAdvanceByShardsIsTheAdvanceInOnePiece) {
  for (const Reconstruction reconstruction : kAll) {
    synthetic::Training training;
    training.options = SdTreeOptions::Recommended();
    training.options.target = SdTreeOptions::Target::kSimple;
    training.options.reconstruction = reconstruction;
    training.options.spatial_threshold = 500;
    training.options.flux_threshold = 0.002f;
    const auto tree = synthetic::Train(training, 3);
    SdTreeStatistics statistics(tree);
    statistics.Record(synthetic::MakeRecords(*tree, training.field, 1, 5, 160000), 9);
    Elsewhere runner;
    const auto sharded = Advance(*tree, statistics, 4, {}, &runner);
    EXPECT_TRUE(sharded->Serialize() == Advance(*tree, statistics, 4)->Serialize())
        << "method " << static_cast<int>(reconstruction);
    if (reconstruction == Reconstruction::kNone || reconstruction == Reconstruction::kNative) {
      EXPECT_EQ(runner.here + runner.elsewhere, 0) << "such a tree costs no more than its way";
    } else {
      EXPECT_GT(runner.elsewhere, 1) << "one shard shows nothing";
    }
  }
}

Bytes RequestOf(const synthetic::RecordedTree& recorded, const DenseRecipe& recipe = {}) {
  TreeRequest request(recipe);
  request.Add(0, recorded.masses);
  request.Add(3, recorded.masses);
  return request.Take();
}

TEST(TreeRequest, WhatIsNoRequestOrAnswerIsRefused) {
  const auto recorded = Lobe(3, 400);
  const Bytes request = RequestOf(recorded), answer = AnswerTreeRequest(request);
  const auto read = [](std::string_view bytes) { return ReadTreeAnswer(bytes, 4, directional::kMaxDepth); };
  ASSERT_EQ(read(answer).size(), 2u);
  EXPECT_THROW(read(request), Error);
  EXPECT_THROW(AnswerTreeRequest(answer), Error);
  EXPECT_THROW(AnswerTreeRequest(""), Error);
  EXPECT_THROW(AnswerTreeRequest(std::string_view(request).substr(0, request.size() - 1)), Error);
  EXPECT_THROW(ReadTreeAnswer(answer, 3, directional::kMaxDepth), Error) << "a place that is none";
  EXPECT_THROW(ReadTreeAnswer(answer, 4, 2), Error) << "a tree deeper than is allowed";
  Bytes flipped = answer;
  flipped[flipped.size() / 2] ^= 1;
  EXPECT_THROW(read(flipped), Error);

  for (const DenseRecipe& recipe : {DenseRecipe{0}, DenseRecipe{HUGE_VALF}, DenseRecipe{1, 0}, DenseRecipe{1, HUGE_VAL},
                                    DenseRecipe{1, 0.01, 0}, DenseRecipe{1, 0.01, 21}})
    EXPECT_THROW(AnswerTreeRequest(RequestOf(recorded, recipe)), Error);
  for (const double mass : {-1.0, std::nan(""), HUGE_VAL}) {
    auto wrong = Lobe(3, 400);
    wrong.masses.nodes = wrong.tree.nodes.data();
    for (size_t slot = 0; slot < wrong.masses.total.size(); ++slot)
      if (wrong.tree.nodes[slot / 4].child[slot % 4] == 0) wrong.masses.total[slot] = mass;
    EXPECT_THROW(AnswerTreeRequest(RequestOf(wrong)), Error) << mass;
    std::fill(wrong.masses.total.begin(), wrong.masses.total.end(), 0.0);
    EXPECT_THROW(AnswerTreeRequest(RequestOf(wrong)), Error) << "no mass at all";
  }
}

TEST(TreeRequest, NoBytesDoHarm) {
  const Bytes request = RequestOf(Lobe(4, 300)), answer = AnswerTreeRequest(request);
  std::mt19937 random(1);
  int refused = 0, taken = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto change = [&](Bytes* content) {
      for (uint32_t n = 1 + random() % 3; n > 0; --n)
        (*content)[random() % content->size()] = static_cast<char>(random());
      if (random() % 4 == 0) content->resize(random() % content->size());
    };
    try {
      (void)AnswerTreeRequest(Resealed(request, change));
      for (const PlacedTree& placed : ReadTreeAnswer(Resealed(answer, change), 4, directional::kMaxDepth))
        EXPECT_GT(directional::Locate(placed.tree.nodes.data(), Vec2{0.3f, 0.7f}).depth, 0);
      ++taken;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(taken, 0);
}

TEST(TreeRequest, AnAnswerWithATreeThatNobodyAskedForIsRefused) {
  synthetic::Training training;
  training.options = SdTreeOptions::Recommended();
  training.options.target = SdTreeOptions::Target::kSimple;
  training.options.reconstruction = Reconstruction::kDenseUnlimited;
  const auto tree = synthetic::Train(training, 3);
  const SdTreeStatistics nothing(tree);
  class Forward final : public ShardRunner {
   public:
    void Run(ShardedWork& work) override {
      EXPECT_TRUE(work.Describe(0).empty());
      TreeRequest request({});
      const auto recorded = Lobe(5, 300);
      request.Add(0, recorded.masses);
      EXPECT_THROW(work.Accept(0, AnswerTreeRequest(request.Take())), Error);
      for (uint32_t shard = 0; shard < work.count(); ++shard) work.DoHere(shard);
      ran = true;
    }
    bool ran = false;
  } runner;
  EXPECT_TRUE(Advance(*tree, nothing, 4, {}, &runner)->Serialize() == Advance(*tree, nothing, 4)->Serialize());
  EXPECT_TRUE(runner.ran);
}

TEST(TreeRequest, AnAdvanceThatHasToGrowCoarserAsksSeveralTimes) {
  synthetic::Training training;
  training.options = SdTreeOptions::Recommended();
  training.options.target = SdTreeOptions::Target::kSimple;
  training.options.reconstruction = Reconstruction::kDenseUnlimited;
  training.options.spatial_threshold = 500;
  const auto tree = synthetic::Train(training, 3);
  // The same trees, with room for less than a node each: thresholds rise beyond one.
  SdTreeOptions narrow = training.options;
  narrow.max_nodes = tree->leaf_count() / 2;
  Bytes bytes = tree->Serialize();
  ByteWriter from, to;
  training.options.Write(from);
  narrow.Write(to);
  bytes.replace(8, from.bytes().size(), to.bytes());
  const auto crowded = SdTree::Parse(bytes);
  SdTreeStatistics sums(crowded);
  sums.Record(synthetic::MakeRecords(*crowded, training.field, 1, 5, 160000), 9);
  Elsewhere runner;
  const auto sharded = Advance(*crowded, sums, 4, {}, &runner);
  EXPECT_TRUE(sharded->Serialize() == Advance(*crowded, sums, 4)->Serialize());
  EXPECT_LT(sharded->node_count(), tree->node_count() / 4);
  EXPECT_GT(runner.elsewhere, 10);
}

TEST(TreeRequest, WhoIsToldToStopAnswersNothing) {
  StopToken stop;
  const Bytes request = RequestOf(Lobe(6, 300));
  EXPECT_FALSE(AnswerTreeRequest(request, stop).empty());
  stop.Request();
  EXPECT_TRUE(AnswerTreeRequest(request, stop).empty());
}

TEST(TreeRequest, TheCanaryIsOneOfThisBuild) {
  EXPECT_EQ(TreeCanary(), TreeCanary());
  EXPECT_EQ(TreeCanary().size(), 16u);
}

}  // namespace
}  // namespace lodestar
