// What a radiance grid learns: exact sums in any partition, the blend of steps, canonical bytes that are refused where
// they are broken.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/guiding/from_bytes.h"
#include "tests/guiding/grid_testing.h"
#include "tests/guiding/merging.h"

namespace lodestar {
namespace {

using namespace grid_testing;

GridOptions Small() {
  GridOptions options;
  options.cells = 2;
  options.directions = 4;
  return options;
}

TEST(GridStatistics, AnyPartitionAndOrderGiveTheSameBytes) {
  const auto grid = Train(Small(), kUnit, 2000);
  struct Value {
    uint32_t cell, direction;
    float luminance;
  };
  Random random(1);
  std::vector<Value> values;
  for (int i = 0; i < 3000; ++i) {
    const float luminance = std::ldexp(random.Next1D(), static_cast<int>(random.Next() % 60) - 30);
    values.push_back({static_cast<uint32_t>(random.Next() % grid->cell_count()),
                      static_cast<uint32_t>(random.Next() % grid->direction_count()), luminance});
  }
  GridStatistics whole(grid);
  for (const Value& v : values) whole.Record(v.cell, v.direction, v.luminance);
  for (const size_t parts : {2u, 7u}) {
    GridStatistics merged(grid);
    for (size_t part = parts; part-- > 0;) {
      GridStatistics one(grid);
      for (size_t i = values.size(); i-- > 0;)
        if (i % parts == part) one.Record(values[i].cell, values[i].direction, values[i].luminance);
      merged.MergeSerialized(one.Serialize());
    }
    EXPECT_TRUE(merged.Serialize() == whole.Serialize());
    EXPECT_TRUE(Advance(*grid, merged)->Serialize() == Advance(*grid, whole)->Serialize());
  }
}

TEST(GridStatistics, MergesEmptySingleAndUnequalParts) {
  const auto grid = Train(Small(), kUnit, 2000);
  const auto part = [&](int first, int end) {
    GridStatistics statistics(grid);
    for (int i = first; i < end; ++i) {
      Random random(static_cast<uint64_t>(i));
      const auto cell = static_cast<uint32_t>(random.Next() % grid->cell_count()),
                 direction = static_cast<uint32_t>(random.Next() % grid->direction_count());
      statistics.Record(cell, direction, std::ldexp(1 + random.Next1D(), static_cast<int>(random.Next() % 40) - 20));
    }
    return statistics;
  };
  ExpectEmptySingleAndUnequalPartsMerge(3000, part);
}

TEST(GridStatistics, WhatIsNoLuminanceIsRefusedAndCounted) {
  const auto grid = RadianceGrid::Initial(kUnit, Small());
  GridStatistics statistics(grid);
  for (const float bad : {-1.0f, std::nanf(""), kInfinity}) statistics.Record(0, 0, bad);
  EXPECT_EQ(statistics.counts(), (GridStatistics::Counts{.accepted = 0, .refused = 3, .saturated = 0}));
  statistics.Record(0, 0, 3e38f);
  EXPECT_EQ(statistics.counts(), (GridStatistics::Counts{.accepted = 1, .refused = 3, .saturated = 1}));
}

TEST(GridStatistics, CorruptBytesAreRefusedOrValid) {
  const auto grid = RadianceGrid::Initial(kUnit, Small());
  const Bytes bytes = Recorded(grid, kUnit, 3, 200).Serialize();
  for (size_t size = 0; size < bytes.size(); size += size < 80 ? 1 : 13)
    ASSERT_THROW(test::FromBytes<GridStatistics>(grid, std::string_view(bytes).substr(0, size)), Error);
  EXPECT_THROW(test::FromBytes<GridStatistics>(grid, bytes + '\0'), Error);
  EXPECT_THROW(test::FromBytes<GridStatistics>(Train(Small(), kUnit, 100), bytes), Error);
  Random random(4);
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Bytes changed = bytes;
    changed[random.Next() % (trial % 2 ? changed.size() : 100)] ^= static_cast<char>(1 << (trial % 8));
    try {
      ASSERT_TRUE(test::FromBytes<GridStatistics>(grid, changed).Serialize() == changed);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
}

TEST(GridAdvance, BlendsByTheNumberOfRecords) {
  GridOptions options = Small();
  options.learning_rate = 0.25f;
  options.prior = 0;
  auto grid = RadianceGrid::Initial(kUnit, options);
  GridStatistics first(grid);
  for (const float value : {1.0f, 2.0f, 6.0f}) first.Record(5, 7, value);
  grid = Advance(*grid, first);
  // The first records are believed at once.
  EXPECT_FLOAT_EQ(grid->Radiance(5, 7), 3);
  const double known = 1 - 0.75 * 0.75 * 0.75;
  EXPECT_FLOAT_EQ(grid->parts().weight[grid->Entry(5, 7)], static_cast<float>(known));
  GridStatistics second(grid);
  second.Record(5, 7, 11);
  second.Record(5, 7, 13);
  grid = Advance(*grid, second);
  const double kept = 0.75 * 0.75, expected = (kept * known * 3 + (1 - kept) * 12) / (kept * known + 1 - kept);
  EXPECT_NEAR(grid->Radiance(5, 7), expected, 1e-5);
  EXPECT_EQ(grid->Radiance(5, 6), 0);
  EXPECT_EQ(grid->iteration(), 2u);
}

TEST(RadianceGrid, LearnsTheMeanRadiance) {
  for (const float prior : {0.0f, 2.0f}) {
    GridOptions options;
    options.cells = 1;
    options.directions = 8;
    options.learning_rate = 0.001f;
    options.prior = prior;
    // Far away, so that all points of the one voxel see the ball in one direction.
    auto grid = RadianceGrid::Initial(kUnit, options);
    GridStatistics statistics(grid);
    Random random(5);
    for (int i = 0; i < 400000; ++i) {
      const Vec3 w = UniformDirection(random);
      statistics.Record(0, grid->DirectionAt(w), 2 * random.Next1D() * (1 + w.z));
    }
    grid = Advance(*grid, statistics);
    for (uint32_t d = 0; d < grid->direction_count(); ++d)
      EXPECT_NEAR(grid->Radiance(0, d), 1 + grid->DirectionCenter(d).z, 0.15) << d;
    EXPECT_NEAR(grid->Fluence(0), 4 * kPi, 0.05);
  }
}

TEST(RadianceGrid, ThePriorFillsGapsAndGivesWayToRecords) {
  GridOptions options;
  options.cells = 1;
  options.prior = 2;
  auto grid = RadianceGrid::Initial(kUnit, options);
  GridStatistics few(grid);
  few.Record(0, 40, 8);
  few.Record(0, 300, 2);
  grid = Advance(*grid, few);
  for (uint32_t d = 0; d < grid->direction_count(); ++d) {
    EXPECT_GT(grid->Radiance(0, d), 2 - 1e-3);
    EXPECT_LT(grid->Radiance(0, d), 8 + 1e-3);
  }
  EXPECT_GT(grid->Radiance(0, 41), grid->Radiance(0, 299));  // from the nearer record
}

TEST(RadianceGrid, EveryPointHasACellAndEveryDirectionAnEntry) {
  for (const Bounds3& box : {kUnit, Bounds3{{0, 0, 0}, {1, 1, 0}}, Bounds3{{5, 5, 5}, {5, 5, 5}},
                             Bounds3{{1e6f, 1e6f, 1e6f}, {1.01e6f, 1.01e6f, 1e6f}}}) {
    GridOptions options;
    options.directions = 4;
    const auto grid = RadianceGrid::Initial(box, options);
    Random random(6);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = PointIn({box.min - Vec3{2, 2, 2}, box.max + Vec3{2, 2, 2}}, random);
      ASSERT_LT(grid->CellAt(x), grid->cell_count());
      ASSERT_LT(grid->DirectionAt(UniformDirection(random)), grid->direction_count());
    }
    for (const float s : {-1.0f, 1.0f})
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 w;
        w[axis] = s;
        ASSERT_LT(grid->DirectionAt(w), grid->direction_count());
      }
    for (uint32_t d = 0; d < grid->direction_count(); ++d) ASSERT_EQ(grid->DirectionAt(grid->DirectionCenter(d)), d);
  }
}

TEST(RadianceGrid, SerialFormIsCanonicalAndBrokenBytesAreRefused) {
  const auto grid = Train(Small(), kUnit, 300);
  const Bytes bytes = grid->Serialize();
  const auto again = RadianceGrid::Parse(bytes);
  EXPECT_EQ(again->fingerprint(), grid->fingerprint());
  EXPECT_TRUE(again->Serialize() == bytes);
  for (size_t size = 0; size < bytes.size(); size += size < 100 ? 1 : 37)
    ASSERT_THROW(RadianceGrid::Parse(std::string_view(bytes).substr(0, size)), Error) << size;
  EXPECT_THROW(RadianceGrid::Parse(bytes + '\0'), Error);
  Random random(7);
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Bytes changed = bytes;
    changed[random.Next() % (trial % 2 ? changed.size() : 100)] ^= static_cast<char>(1 << (trial % 8));
    try {
      ASSERT_TRUE(RadianceGrid::Parse(changed)->Serialize() == changed);
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::kCorrupt);
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);
}

TEST(RadianceGrid, BadBoundsAndSettingsAreRefused) {
  EXPECT_THROW(RadianceGrid::Initial(Bounds3{}, {}), Error);
  EXPECT_THROW(RadianceGrid::Initial({{0, 0, 0}, {kInfinity, 1, 1}}, {}), Error);
  const auto refused = [](auto change) {
    GridOptions options;
    change(options);
    EXPECT_THROW(RadianceGrid::Initial(kUnit, options), Error);
  };
  refused([](GridOptions& o) { o.cells = 0; });
  refused([](GridOptions& o) { o.cells = 33; });
  refused([](GridOptions& o) { o.directions = 12; });
  refused([](GridOptions& o) { o.directions = o.cells = 32; });
  refused([](GridOptions& o) { o.learning_rate = 0; });
  refused([](GridOptions& o) { o.prior = std::nanf(""); });
}

}  // namespace
}  // namespace lodestar
