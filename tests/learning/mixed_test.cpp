#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/learning/mixed_guiding.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

std::unique_ptr<Method> Make(const std::map<std::string, std::string>& options = {}) {
  JobSpec job = test::SyntheticJob("sdtree+focal", 64);
  job.options = options;
  return MakeMethod(job, test::SyntheticSurvey());
}

std::unique_ptr<Statistics> Recorded(const Method& method, const std::shared_ptr<const State>& state, uint64_t key) {
  auto statistics = method.NewStatistics(state);
  auto& both = dynamic_cast<MixedStatistics&>(*statistics);
  Sampler sampler(key, 0, 0, 0);
  std::vector<SdTreeRecord> records;
  for (int i = 0; i < 200; ++i) {
    const Vec2 u = sampler.Next2D(), v = sampler.Next2D();
    const Vec3 p{u.x, u.y, v.x}, w = Normalize(Vec3{v.y - 0.5f, u.x - 0.5f, 0.7f});
    records.push_back({.position = p, .direction = w, .radiance = u.x, .pdf = 0.3f, .bsdf_pdf = 0.2f, .product = u.y});
    both.focal().sums().Record({.position = p, .direction = w, .distance = 0.5f, .value = u.y, .pdf = 0.3f});
  }
  const auto& tree = dynamic_cast<const MixedState&>(*state).tree()->tree();
  for (SdTreeRecord& record : records) record.leaf = tree.LeafAt(record.position);
  both.tree().sums().Record(records, key);
  return statistics;
}

TEST(Mixed, StatisticsOfBothPartsTravelTogether) {
  const auto method = Make();
  const auto state = method->Initial();
  const auto a = Recorded(*method, state, 1), b = Recorded(*method, state, 2);
  const auto sum = method->NewStatistics(state), direct = method->NewStatistics(state);
  for (const auto* part : {&b, &a}) sum->MergeSerialized((*part)->Serialize());
  for (const auto* part : {&a, &b}) direct->Merge(**part);
  EXPECT_EQ(sum->Serialize(), direct->Serialize());
  EXPECT_NE(sum->Serialize(), a->Serialize());
}

TEST(Mixed, WhatIsRefusedChangesNothing) {
  const auto method = Make({{"roulette", "contribution"}});  // needs no picture
  const auto state = method->Initial();
  const auto sum = Recorded(*method, state, 1);
  const Bytes before = sum->Serialize();
  // Each part's from a later state: the tree's is refused after the focal one was read, and the other way round.
  const auto next = method->Advance(state, {.statistics = sum.get(), .passes = 1, .image = nullptr});
  const auto& now = dynamic_cast<const MixedState&>(*state);
  const auto& later = dynamic_cast<const MixedState&>(*next);
  for (const MixedState& crossed : {MixedState(later.tree(), now.focal()), MixedState(now.tree(), later.focal())}) {
    const Bytes bytes = method->NewStatistics(std::make_shared<MixedState>(crossed))->Serialize();
    EXPECT_THROW(sum->MergeSerialized(bytes), Error);
    EXPECT_EQ(sum->Serialize(), before);
  }
  for (size_t length : {size_t{0}, size_t{9}, before.size() / 2, before.size() - 1}) {
    EXPECT_THROW(sum->MergeSerialized(std::string_view(before).substr(0, length)), Error);
    EXPECT_EQ(sum->Serialize(), before);
  }
}

TEST(Mixed, StatesTravel) {
  const auto method = Make(
      {{"initial-iterations", "2"}, {"narrowing-iterations", "1"}, {"roulette", "contribution"}, {"target", "simple"}});
  auto state = method->Initial();
  for (int i = 0; i < 5; ++i) {
    const Bytes bytes = state->Serialize();
    EXPECT_EQ(method->ParseState(bytes)->Serialize(), bytes);
    EXPECT_THROW(method->ParseState(std::string_view(bytes).substr(0, bytes.size() - 1)), Error);
    const auto statistics = Recorded(*method, state, 3);
    state = method->Advance(state, {.statistics = statistics.get(), .passes = 1, .image = nullptr});
    // The octree has three iterations; the tree goes on.
    const auto& both = dynamic_cast<const MixedState&>(*state);
    EXPECT_EQ(both.focal()->field().iteration(), static_cast<uint32_t>(std::min(i + 1, 3)));
    EXPECT_EQ(both.tree()->tree().iteration(), static_cast<uint32_t>(i + 1));
  }
}

TEST(Mixed, TakesTheOptionsOfBothParts) {
  EXPECT_NO_THROW(Make({{"spatial-threshold", "2000"}, {"narrow-factor", "2"}}));
  for (const auto& [name, value] : std::map<std::string, std::string>{
           {"product", "on"}, {"passes", "2"}, {"narrow-factor", "99"}, {"spatial-threshold", "0"}, {"grid", "1"}})
    EXPECT_THROW(Make({{name, value}}), Error) << name;
}

TEST(Mixed, IterationsGrowByTheSquareRootOfTwo) {
  const auto method = Make();
  const auto state = method->Initial();
  std::vector<uint64_t> passes;
  for (uint32_t i = 0; i < 10; ++i) passes.push_back(method->IterationPasses(*state, i));
  EXPECT_EQ(passes, (std::vector<uint64_t>{1, 1, 2, 3, 4, 6, 8, 11, 16, 23}));
}

}  // namespace
}  // namespace lodestar
