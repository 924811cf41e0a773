#include "core/guiding/focal_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/guiding/focal_testing.h"
#include "tests/guiding/from_bytes.h"
#include "tests/guiding/merging.h"

namespace lodestar {
namespace {

using focal_testing::MakeRecord;
using focal_testing::Random;
using focal_testing::RandomField;
using focal_testing::Train;
using focal_testing::Training;

double Total(const FocalStatistics& statistics) {
  double sum = 0;
  for (uint32_t slot = 0; slot < statistics.slot_count(); ++slot) sum += statistics.sum(slot).Value();
  return sum;
}

// A record from the middle of a face of the unit cube straight through it.
FocalRecord Through(float distance, float value) {
  FocalRecord r;
  r.position = {0.01f, 0.31f, 0.32f};
  r.direction = {1, 0, 0};
  r.distance = distance;
  r.value = value;
  r.pdf = r.bsdf_pdf = r.guide_pdf = 1;
  return r;
}

TEST(FocalStatistics, InitialIterationsShareByLength) {
  const auto field = FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {});
  FocalStatistics statistics(field);
  statistics.Record(Through(0.5f, 3));
  EXPECT_NEAR(Total(statistics), 3, 1e-6);
  const float side = field->sides().x, voxel = side / 8;
  double sum = 0;
  field->octrees()[0].ForVoxels(field->RayOf({0.01f, 0.31f, 0.32f}, {1, 0, 0}), 0.5f / field->longest_side(),
                                [&](uint32_t slot, float t0, float t1, float) {
                                  const double expected = 3 * (t1 - t0) * field->longest_side() / 0.5;
                                  EXPECT_NEAR(statistics.sum(slot).Value(), expected, 1e-5);
                                  EXPECT_LE(t1 - t0, voxel / side + 1e-6f);
                                  sum += statistics.sum(slot).Value();
                                });
  EXPECT_NEAR(sum, 3, 1e-5);
}

TEST(FocalStatistics, NarrowingSharesByWhatVoxelsContributeToTheDensity) {
  for (const float factor : {1.0f, 2.0f}) {
    FocalParts parts = PartsOf(*RandomField({{0, 0, 0}, {1, 1, 1}}, 6, 3));
    parts.options.narrow_factor = factor;
    parts.options.by_mixture = false;
    parts.iteration = 6;
    const auto field = std::make_shared<const FocalField>(std::move(parts));
    FocalStatistics statistics(field);
    const FocalRecord record = Through(kInfinity, 2);
    statistics.Record(record);
    EXPECT_NEAR(Total(statistics), 2, 1e-5);
    std::vector<std::pair<uint32_t, double>> expected;
    double total = 0;
    field->octrees()[0].ForVoxels(field->RayOf(record.position, record.direction), kInfinity,
                                  [&](uint32_t slot, float t0, float t1, float) {
                                    // a_v p_v with p_v = (t1^3 - t0^3) / (3 |V_v|), ALGORITHMS section 5.
                                    int level = field->octrees()[0].node(slot / 8).level;
                                    const double volume = std::ldexp(1.0, -3 * level), d0 = t0, d1 = t1;
                                    const double p = (d1 * d1 * d1 - d0 * d0 * d0) / (3 * volume);
                                    expected.push_back({slot, std::pow(field->octrees()[0].mass(slot) * p, factor)});
                                    total += expected.back().second;
                                  });
    for (const auto& [slot, weight] : expected)
      EXPECT_NEAR(statistics.sum(slot).Value(), 2 * weight / total, 1e-5) << factor;
  }
}

TEST(FocalStatistics, NarrowingByTheMixtureLeavesOutTheBsdfsShare) {
  FocalParts parts = PartsOf(*RandomField({{0, 0, 0}, {1, 1, 1}}, 6, 3));
  parts.iteration = 6;
  for (const bool by_mixture : {false, true}) {
    parts.options.by_mixture = by_mixture;
    FocalStatistics statistics(std::make_shared<const FocalField>(parts));
    FocalRecord record = Through(kInfinity, 2);
    record.bsdf_pdf = 0.3f;
    record.guide_pdf = 0.1f;
    record.pdf = 0.5f * record.bsdf_pdf + 0.5f * record.guide_pdf;
    statistics.Record(record);
    EXPECT_NEAR(Total(statistics), by_mixture ? 2 * 0.25 : 2, 1e-5);
  }
}

// Nothing was guided until then, so all light is the BSDF's find: its share left out, the field would stay empty.
TEST(FocalStatistics, AFieldThatHasMetNoLightBeginsLate) {
  FocalParts parts = PartsOf(*FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {}));
  parts.iteration = 8;
  ASSERT_TRUE(parts.options.Narrows(parts.iteration) && parts.options.by_mixture);
  FocalStatistics statistics(std::make_shared<const FocalField>(std::move(parts)));
  FocalRecord record = Through(0.5f, 3);
  record.guide_pdf = 0;
  statistics.Record(record);
  EXPECT_NEAR(Total(statistics), 3, 1e-5);
}

TEST(FocalStatistics, WhereNoVoxelHasMassTheLengthCounts) {
  FocalParts parts = PartsOf(*FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {}));
  parts.iteration = 6;
  parts.options.by_mixture = false;
  std::fill(parts.octrees[0].leaf_masses.begin(), parts.octrees[0].leaf_masses.end(), 0.0f);
  parts.octrees[0].leaf_masses.back() = 1;
  parts.weight = 1;
  FocalStatistics statistics(std::make_shared<const FocalField>(std::move(parts)));
  statistics.Record(Through(0.5f, 3));
  EXPECT_NEAR(Total(statistics), 3, 1e-6);
}

TEST(FocalStatistics, MergesToTheSameBitsInAnyOrder) {
  Training training;
  training.options.learn_fraction = true;
  training.records = 3000;
  for (const uint32_t iterations : {0u, 8u}) {
    const auto field = Train(training, iterations);
    Random random(3);
    std::vector<FocalRecord> records;
    for (int i = 0; i < 3000; ++i) records.push_back(MakeRecord(*field, training, random));
    FocalStatistics whole(field);
    for (const FocalRecord& r : records) whole.Record(r);
    std::vector<FocalStatistics> parts;
    for (int i = 0; i < 7; ++i) parts.emplace_back(field);
    for (size_t i = records.size(); i-- > 0;) parts[i % 5 + (i % 3 == 0 ? 2 : 0)].Record(records[i]);
    parts[6].Merge(parts[1]);
    parts[0].Merge(parts[4]);
    parts[6].Merge(parts[0]);
    for (const int i : {5, 3, 2}) parts[6].Merge(parts[i]);
    EXPECT_TRUE(parts[6].Serialize() == whole.Serialize());
    const FocalStatistics again = test::FromBytes<FocalStatistics>(field, whole.Serialize());
    EXPECT_TRUE(again.Serialize() == whole.Serialize());
    EXPECT_EQ(Advance(*field, again)->fingerprint(), Advance(*field, parts[6])->fingerprint());
    EXPECT_EQ(again.counts(), whole.counts());
  }
}

TEST(FocalStatistics, MergesEmptySingleAndUnequalParts) {
  Training training;
  training.options.learn_fraction = true;
  training.records = 2000;
  const auto field = Train(training, 8);
  Random random(4);
  std::vector<FocalRecord> records;
  for (int i = 0; i < 2000; ++i) records.push_back(MakeRecord(*field, training, random));
  const auto part = [&](int first, int end) {
    FocalStatistics statistics(field);
    for (int i = first; i < end; ++i) statistics.Record(records[static_cast<size_t>(i)]);
    return statistics;
  };
  ExpectEmptySingleAndUnequalPartsMerge(2000, part);
}

TEST(FocalStatistics, BytesAreSparse) {
  const auto field = Train({}, 10);
  FocalStatistics statistics(field);
  const size_t empty = statistics.Serialize().size();
  EXPECT_LT(empty, 150u);
  statistics.Record(Through(0.2f, 1));
  EXPECT_LT(statistics.Serialize().size(), empty + 20 * 100);
}

TEST(FocalStatistics, UnusableRecordsAreCounted) {
  const auto field = FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {});
  FocalStatistics statistics(field);
  for (const float value : {std::nanf(""), kInfinity, -1.0f}) statistics.Record(Through(1, value));
  FocalRecord r = Through(0, 1);
  statistics.Record(r);
  r.distance = 1;
  r.position.x = std::nanf("");
  statistics.Record(r);
  EXPECT_EQ(statistics.counts().refused, 5u);
  r = Through(1, 1);
  r.position = {50, 50, 50};
  statistics.Record(r);
  EXPECT_EQ(statistics.counts().missed, 1u);
  EXPECT_EQ(Total(statistics), 0);
  statistics.Record(Through(1, 3e38f));
  EXPECT_GT(statistics.counts().saturated, 0u);
}

TEST(FocalStatistics, CorruptBytesAreRefusedOrValid) {
  Training training;
  training.options.learn_fraction = true;
  training.records = 200;
  const auto field = Train(training, 7);
  const Bytes bytes = focal_testing::Recorded(field, training, 5, 50).Serialize();
  for (size_t size = 0; size < bytes.size(); size += size < 300 ? 1 : 41)
    ASSERT_THROW(test::FromBytes<FocalStatistics>(field, std::string_view(bytes).substr(0, size)), Error) << size;
  EXPECT_THROW(test::FromBytes<FocalStatistics>(field, bytes + '\0'), Error);
  EXPECT_THROW(test::FromBytes<FocalStatistics>(Train(training, 6), bytes), Error);
  Random random(12);
  int refused = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    Bytes changed = bytes;
    for (int flips = 1 + trial % 3; flips > 0; --flips)
      changed[random.Next() % changed.size()] ^= static_cast<char>(1 << (trial % 8));
    try {
      ASSERT_TRUE(test::FromBytes<FocalStatistics>(field, changed).Serialize() == changed);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace lodestar
