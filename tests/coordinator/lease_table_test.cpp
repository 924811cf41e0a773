#include "coordinator/lease_table.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const WorkerId kAnn{"ann"}, kBob{"bob"}, kCid{"cid"};

struct LeaseTableTest : testing::Test {
  ManualClock clock;
  BusyClock busy{clock};
  LeaseTable::Options options;
  uint64_t last = 0;
  LeaseId Next() { return {++last}; }
};

TEST_F(LeaseTableTest, GrantsAlignedBlocksFromBelow) {
  LeaseTable table(20, options, clock, busy);
  const auto a = table.Grant(Next(), kAnn, 8);
  ASSERT_TRUE(a);
  EXPECT_EQ(a->node, (TreeNode{3, 0}));
  EXPECT_EQ(table.Grant(Next(), kBob, 8)->node, (TreeNode{3, 1}));
  // The rest, 16 to 19, is cut by the round's end: a block of level 2, though three levels up would also be free.
  const auto c = table.Grant(Next(), kAnn, 4);
  EXPECT_EQ(c->node, (TreeNode{2, 4}));
  EXPECT_EQ(table.free_units(), 0u);
  EXPECT_FALSE(table.Grant(Next(), kBob, 8));
}

TEST_F(LeaseTableTest, ExpiryFreesAndRenewalKeeps) {
  LeaseTable table(8, options, clock, busy);
  const auto a = table.Grant(Next(), kAnn, 4), b = table.Grant(Next(), kBob, 4);
  clock.Advance(seconds(6));
  EXPECT_TRUE(table.Renew(a->id, kAnn));
  EXPECT_FALSE(table.Renew(a->id, kBob)) << "somebody else's lease";
  clock.Advance(seconds(5));
  const auto expired = table.Expire();
  ASSERT_EQ(expired.size(), 1u);
  EXPECT_EQ(expired[0].id, b->id);
  EXPECT_FALSE(table.Renew(b->id, kBob));
  EXPECT_EQ(table.Grant(Next(), kCid, 8)->node, b->node) << "re-leased";
}

TEST_F(LeaseTableTest, CommitsVoidWhatTheyCover) {
  LeaseTable table(8, options, clock, busy);
  const auto a = table.Grant(Next(), kAnn, 2), b = table.Grant(Next(), kBob, 2);
  EXPECT_TRUE(table.Commit({2, 0}).size() == 2) << "an ancestor covers both";
  EXPECT_TRUE(table.Covered(a->node) && table.Covered(b->node));
  EXPECT_TRUE(table.leases().empty());
  EXPECT_TRUE(table.Commit({2, 0}).empty()) << "a repetition changes nothing";
  EXPECT_EQ(table.free_units(), 4u);
  EXPECT_FALSE(table.complete());
  table.Commit({2, 1});
  EXPECT_TRUE(table.complete());
}

TEST_F(LeaseTableTest, LateResultsCountWithoutALease) {
  LeaseTable table(4, options, clock, busy);
  const auto a = table.Grant(Next(), kAnn, 4);
  clock.Advance(seconds(11));
  table.Expire();
  const auto b = table.Grant(Next(), kBob, 2);  // of the lower half
  const auto voided = table.Commit(a->node);    // Ann's comes after all
  ASSERT_EQ(voided.size(), 1u);
  EXPECT_EQ(voided[0].id, b->id);
  EXPECT_TRUE(table.complete());
}

TEST_F(LeaseTableTest, ByteBudgetHoldsResultsBack) {
  options.byte_budget = 1000;
  LeaseTable table(64, options, clock, busy);
  table.set_bytes_per_unit(150);
  EXPECT_TRUE(table.Grant(Next(), kAnn, 4));
  EXPECT_TRUE(table.Grant(Next(), kAnn, 4));
  EXPECT_FALSE(table.Grant(Next(), kBob, 4)) << "eight units are out";
  table.Commit({2, 0});
  EXPECT_TRUE(table.Grant(Next(), kBob, 4));
  // One lease always goes out, whatever it weighs.
  LeaseTable heavy(4, options, clock, busy);
  heavy.set_bytes_per_unit(1e9);
  EXPECT_TRUE(heavy.Grant(Next(), kAnn, 1));
}

TEST_F(LeaseTableTest, StragglersAreSplitAndDoubled) {
  LeaseTable table(8, options, clock, busy);
  const auto a = table.Grant(Next(), kAnn, 8);
  ASSERT_EQ(a->node, (TreeNode{3, 0}));
  // Expected: 8 units of 0.1 s. Not a straggler before three times that and the grace.
  clock.Advance(seconds(2));
  EXPECT_FALSE(table.GrantCopy(Next(), kBob, 0.1));
  clock.Advance(seconds(1));
  EXPECT_FALSE(table.GrantCopy(Next(), kAnn, 0.1)) << "nobody doubles himself";
  const auto upper = table.GrantCopy(Next(), kBob, 0.1), lower = table.GrantCopy(Next(), kCid, 0.1);
  ASSERT_TRUE(upper && lower);
  EXPECT_EQ(upper->node, (TreeNode{2, 1}));
  EXPECT_EQ(lower->node, (TreeNode{2, 0}));
  EXPECT_FALSE(table.GrantCopy(Next(), WorkerId{"dan"}, 0.1)) << "two copies of a unit are enough";
  EXPECT_EQ(table.Commit(upper->node).size(), 1u) << "the straggler still holds the lower half";
  EXPECT_EQ(table.Commit(lower->node).size(), 2u) << "now it has nothing left to do";
  EXPECT_TRUE(table.complete());
}

TEST_F(LeaseTableTest, RandomHistoriesEndCompleteAndConsistent) {
  for (uint32_t seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    const uint32_t count = 1 + random() % 200;
    LeaseTable table(count, options, clock, busy);
    std::vector<bool> covered(count, false);
    const WorkerId workers[] = {kAnn, kBob, kCid};
    int steps = 0;
    while (!table.complete() && ++steps < 20000) {
      const WorkerId& worker = workers[random() % 3];
      switch (random() % 5) {
        case 0:
          table.Grant(Next(), worker, 1 + random() % 16);
          break;
        case 1:
          table.GrantCopy(Next(), worker, 0.001);
          break;
        case 2:
          clock.Advance(milliseconds(random() % 3000));
          break;
        case 3:
          table.Expire();
          break;
        default:
          if (table.leases().empty()) break;
          auto it = table.leases().begin();
          std::advance(it, random() % table.leases().size());
          if (random() % 4 == 0) {
            table.Release(it->first);
          } else {
            const TreeNode node = it->second.node;
            for (uint32_t u = node.first(); u < node.end(count); ++u) covered[u] = true;
            table.Commit(node);
          }
      }
      for (const auto& [id, lease] : table.leases()) ASSERT_FALSE(table.Covered(lease.node));
    }
    ASSERT_TRUE(table.complete()) << "seed " << seed;
    EXPECT_EQ(std::count(covered.begin(), covered.end(), false), 0);
    EXPECT_TRUE(table.leases().empty());
    EXPECT_EQ(table.free_units(), 0u);
  }
}

// Who gathers several leases before he delivers is not late while all of them together are not.
TEST_F(LeaseTableTest, WhatAWorkerHoldsIsExpectedTogether) {
  LeaseTable table(16, options, clock, busy);
  const auto first = table.Grant(Next(), kAnn, 8);
  clock.Advance(milliseconds(800));
  const auto second = table.Grant(Next(), kAnn, 8);
  clock.Advance(milliseconds(2000));  // alone, the first would be late by now: 8 units of 0.1 s
  EXPECT_FALSE(table.GrantCopy(Next(), kBob, 0.1));
  clock.Advance(milliseconds(2400));  // 16 units, three times, and the grace
  const auto copy = table.GrantCopy(Next(), kBob, 0.1);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->node, second->node.Child(1)) << "what is likely to be done last";
}

TEST_F(LeaseTableTest, BusyWhileALeaseIsOut) {
  const auto passes = [&](bool counted) {
    const auto before = busy.Now();
    clock.Advance(seconds(1));
    return busy.Now() - before == (counted ? seconds(1) : seconds(0));
  };
  EXPECT_TRUE(passes(false));
  {
    LeaseTable table(8, options, clock, busy), next(8, options, clock, busy);
    EXPECT_TRUE(passes(false));
    const auto a = table.Grant(Next(), kAnn, 2), b = table.Grant(Next(), kBob, 2);
    EXPECT_TRUE(passes(true)) << "and two count once";
    table.Release(a->id);
    EXPECT_TRUE(passes(true));
    table.Commit(b->node);
    EXPECT_TRUE(passes(false));
    ASSERT_TRUE(next.Grant(Next(), kCid, 2));
    clock.Advance(options.duration);
    EXPECT_EQ(next.Expire().size(), 1u);
    EXPECT_TRUE(passes(false)) << "its worker is lost";
    ASSERT_TRUE(next.Grant(Next(), kCid, 2));
    EXPECT_TRUE(passes(true));
  }
  EXPECT_TRUE(passes(false)) << "the round is over";
}

TEST(LeaseUnits, ShareARoundAndShrinkTowardItsEnd) {
  uint32_t free = 1024, leases = 0, last = 1024;
  while (free > 0) {
    const uint32_t units = std::min(free, LeaseUnits(free, 1024, 0.5, 0.001, false));
    EXPECT_LE(units, last) << "where " << free << " are left";
    free -= last = units;
    ++leases;
  }
  EXPECT_LE(leases, 40u) << "each an eighth of what is left";
  EXPECT_LE(last, 16u) << "so that all end together: a fiftieth of a second";
  EXPECT_GE(LeaseUnits(100, 1024, 0.5, 0.001, true), 256u) << "where more follows there is no tail to be short for";
  EXPECT_EQ(LeaseUnits(1, 1, 0.002, 0, false), 1u);
  EXPECT_LE(LeaseUnits(1024, 1024, 0.5, 0, true), 64u) << "nothing is known yet";
}

TEST(LeaseUnits, FollowTheWorkersSpeed) {
  // One worker is seven times as fast as the other: what each takes should last alike.
  const uint32_t fast = LeaseUnits(1024, 1024, 7 / 8.0, 0.001, false),
                 slow = LeaseUnits(1024, 1024, 1 / 8.0, 0.007, false);
  EXPECT_EQ(fast, 8 * slow);
}

TEST(LeaseUnits, HaveTwoSecondsOfWorkWhereTheRoundIsLongEnough) {
  for (const double seconds : {0.01, 0.1, 0.5}) {
    const double work = seconds * LeaseUnits(100000, 100000, 0.25, seconds, true);
    EXPECT_GE(work, 2 / 1.5) << seconds << ": blocks are powers of two";
    EXPECT_LE(work, 2 * 1.5) << seconds;
  }
  EXPECT_EQ(LeaseUnits(1000, 1000, 1.0, 60, false), 1u) << "a unit of a minute goes out alone";
}

TEST(LeaseUnits, AreNotTooSmallForTheirCall) {
  EXPECT_GE(0.0001 * LeaseUnits(100, 1024, 0.5, 0.0001, false), 0.02 / 8) << "what is left, at the end";
  EXPECT_GE(0.0001 * LeaseUnits(1024, 1024, 0.5, 0.0001, false), 0.02 / 1.5);
  EXPECT_LE(LeaseUnits(400, 1024, 0.5, 0.00001, false), 256u) << "nobody takes what is others' part";
}

}  // namespace
}  // namespace lodestar
