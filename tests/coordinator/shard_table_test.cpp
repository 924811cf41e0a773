// Shards are done once each, whoever does them, and nobody is waited for.
#include "coordinator/shard_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

namespace lodestar {
namespace {

// Counts how often each shard was done here, and by an answer.
class Counting : public ShardedWork {
 public:
  explicit Counting(uint32_t count) : here(count), taken(count) {}
  uint32_t count() const override { return static_cast<uint32_t>(here.size()); }
  void DoHere(uint32_t shard) override { ++here[shard]; }
  Bytes Describe(uint32_t shard) const override { return "shard " + std::to_string(shard); }
  void Accept(uint32_t shard, std::string_view answer) override {
    if (answer != "did shard " + std::to_string(shard)) throw Error(ErrorKind::kCorrupt, "no answer");
    ++taken[shard];
  }
  bool EachOnce() const {
    for (size_t i = 0; i < here.size(); ++i)
      if (here[i] + taken[i] != 1) return false;
    return true;
  }
  std::vector<std::atomic<int>> here, taken;
};

constexpr size_t kMost = 1000;
constexpr LeaseId kFirst{1}, kSecond{2}, kThird{3};
const WorkerId kWorker{"worker"};

TEST(ShardTable, AllIsDoneHereWhereNobodyAsks) {
  for (const uint32_t count : {0u, 1u, 100u}) {
    Counting work(count);
    ShardTable table(work, kMost);
    std::atomic<uint32_t> calls = 0;
    table.Run([&] { ++calls; });
    EXPECT_TRUE(work.EachOnce());
    EXPECT_EQ(calls, count);
    EXPECT_EQ(table.accepted(), 0u);
    EXPECT_FALSE(table.Grant(kFirst, kWorker)) << "it is over";
  }
}

TEST(ShardTable, WorkersHaveTheLast) {
  Counting work(10);
  ShardTable table(work, kMost);
  ASSERT_TRUE(table.Grant(kFirst, kWorker));
  ASSERT_TRUE(table.Grant(kSecond, kWorker));
  EXPECT_EQ(table.Describe(kFirst), "shard 9");
  EXPECT_EQ(table.Describe(kSecond), "shard 8");
  EXPECT_TRUE(table.Holds(kFirst));
  EXPECT_TRUE(table.Accept(kFirst, "did shard 9"));
  EXPECT_FALSE(table.Holds(kFirst));
  EXPECT_FALSE(table.Accept(kFirst, "did shard 9")) << "it came twice";
  EXPECT_TRUE(table.Accept(kSecond, "did shard 8"));
  table.Run([] {});
  EXPECT_TRUE(work.EachOnce());
  EXPECT_EQ(work.taken[9] + work.taken[8], 2);
  EXPECT_EQ(table.accepted(), 2u);
}

TEST(ShardTable, WhatAWorkerDoesNotBringIsDoneHere) {
  Counting work(3);
  ShardTable table(work, kMost);
  for (const LeaseId lease : {kFirst, kSecond, kThird}) ASSERT_TRUE(table.Grant(lease, kWorker));
  EXPECT_FALSE(table.Grant({4}, kWorker)) << "all are out";
  table.Release(kSecond);
  EXPECT_FALSE(table.Holds(kSecond));
  ASSERT_TRUE(table.Grant({4}, kWorker));
  EXPECT_EQ(table.Describe({4}), "shard 1");
  table.Run([] {});
  EXPECT_TRUE(work.EachOnce());
  EXPECT_EQ(table.accepted(), 0u);
  for (const LeaseId lease : {kFirst, kThird, LeaseId{4}}) {
    EXPECT_FALSE(table.Holds(lease));
    EXPECT_TRUE(table.Describe(lease).empty());
    EXPECT_FALSE(table.Accept(lease, "did shard 0")) << "too late";
  }
  std::vector<LeaseId> told;
  for (const LeaseEntry& lease : table.TakeVoid()) told.push_back(lease.id);
  std::ranges::sort(told);
  EXPECT_EQ(told, (std::vector<LeaseId>{kFirst, kThird, {4}})) << "kSecond was given back";
  EXPECT_TRUE(table.TakeVoid().empty());
  EXPECT_TRUE(work.EachOnce());
}

TEST(ShardTable, WhatIsNoAnswerIsDoneHereAndNotGivenOutAgain) {
  Counting work(2);
  ShardTable table(work, kMost);
  ASSERT_TRUE(table.Grant(kFirst, kWorker));
  EXPECT_THROW(table.Accept(kFirst, "something else"), Error);
  ASSERT_TRUE(table.Grant(kSecond, kWorker));
  EXPECT_EQ(table.Describe(kSecond), "shard 0");
  EXPECT_FALSE(table.Grant(kThird, kWorker));
  table.Run([] {});
  EXPECT_TRUE(work.EachOnce());
}

TEST(ShardTable, WhatIsTooLargeOrNothingToSendStays) {
  class Sizes final : public Counting {
   public:
    using Counting::Counting;
    Bytes Describe(uint32_t shard) const override { return Bytes(shard == 1 ? 11 : shard == 2 ? 0 : 10, 'x'); }
  } work(3);
  ShardTable table(work, 10);
  ASSERT_TRUE(table.Grant(kFirst, kWorker));
  EXPECT_TRUE(table.Describe(kFirst).empty());
  EXPECT_FALSE(table.Holds(kFirst));
  ASSERT_TRUE(table.Grant(kSecond, kWorker));
  EXPECT_TRUE(table.Describe(kSecond).empty());
  ASSERT_TRUE(table.Grant(kThird, kWorker));
  EXPECT_EQ(table.Describe(kThird).size(), 10u);
  table.Run([] {});
  EXPECT_TRUE(work.EachOnce());
}

TEST(ShardTable, AnExceptionEndsItAndLateAnswersTouchNothing) {
  class Failing final : public Counting {
   public:
    using Counting::Counting;
    void DoHere(uint32_t) override { throw std::runtime_error("out of something"); }
  };
  auto work = std::make_unique<Failing>(4);
  ShardTable table(*work, kMost);
  ASSERT_TRUE(table.Grant(kFirst, kWorker));
  EXPECT_THROW(table.Run([] {}), std::runtime_error);
  work.reset();
  EXPECT_TRUE(table.Describe(kFirst).empty());
  EXPECT_FALSE(table.Accept(kFirst, "did shard 3"));
}

TEST(ShardTable, ManyWorkersOfEveryKind) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    Counting work(200);
    auto table = std::make_shared<ShardTable>(work, kMost);
    std::atomic<uint64_t> leases = 0;
    std::atomic<bool> over = false;
    std::atomic<uint32_t> accepted = 0;
    std::vector<std::jthread> workers;
    for (uint32_t w = 0; w < 3; ++w) {
      workers.emplace_back([&, w] {
        std::mt19937 random(seed * 10 + w);
        while (!over) {
          const LeaseId lease{++leases};
          if (!table->Grant(lease, kWorker)) break;
          const Bytes asked = table->Describe(lease);
          switch (random() % 5) {
            case 0:  // lost
              break;
            case 1:
              table->Release(lease);
              break;
            case 2:
              try {
                (void)table->Accept(lease, "garbage");
              } catch (const Error&) {
              }
              break;
            default:
              if (!asked.empty() && table->Accept(lease, "did " + asked)) ++accepted;
          }
        }
      });
    }
    table->Run([] { std::this_thread::yield(); });
    over = true;
    workers.clear();
    EXPECT_TRUE(work.EachOnce());
    EXPECT_EQ(table->accepted(), accepted);
  }
}

}  // namespace
}  // namespace lodestar
