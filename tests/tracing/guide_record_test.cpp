// What the focal and the grid guide record of a path: paths made by hand, against records written down from the rules.
#include <gtest/gtest.h>

#include "core/tracing/focal_guide.h"
#include "core/tracing/grid_guide.h"
#include "tests/guiding/grid_testing.h"

namespace lodestar {
namespace {

const Bounds3 kUnit{{0, 0, 0}, {1, 1, 1}};

// A vertex that directions are recorded at, whose direction was drawn by a diffuse lobe.
PathVertex Diffuse(Vec3 p, Vec3 wi, float distance) {
  return {.weight = {0.5f, 0.25f, 0.75f},
          .beta = Rgb(1),
          .distance = distance,
          .alpha = 1,
          .p = p,
          .wi = wi,
          .pdf = 0.4f,
          .bsdf_pdf = 0.3f,
          .guide_pdf = 0.2f,
          .smooth = true,
          .recorded = true};
}
PathVertex Lamp(float distance) {
  return {.emitted = {8, 4, 2}, .emission_weight = 0.5f, .distance = distance};
}
// Not recorded: a delta lobe, or one that is almost.
PathVertex Mirror(float distance, float alpha) {
  return {.weight = {0.9f, 0.8f, 0.7f}, .beta = {0.5f, 0.25f, 0.75f}, .distance = distance, .alpha = alpha};
}

// ---- Focal guiding ----

struct FocalPath {
  std::shared_ptr<const FocalState> state;

  explicit FocalPath(bool images = true) {
    FocalOptions options;
    options.images = images;
    state = std::make_shared<FocalState>(FocalField::Initial(kUnit, options));
  }
  FocalStatistics Recorded(const std::vector<PathVertex>& vertices) const {
    FocalGuidingStatistics statistics{FocalStatistics(state->shared_field())};
    FocalGuide::Scratch scratch;
    FocalGuide(state).Record(vertices, {}, &scratch, &statistics);
    return std::move(statistics.sums());
  }
  // The sums of segments written down by hand.
  FocalStatistics Of(const std::vector<FocalRecord>& records) const {
    FocalStatistics statistics(state->shared_field());
    for (const FocalRecord& record : records) statistics.Record(record);
    return statistics;
  }
};

FocalRecord Segment(const PathVertex& from, float distance, Rgb brought) {
  return {.position = from.p,
          .direction = from.wi,
          .distance = distance,
          .value = Luminance(brought),
          .pdf = from.pdf,
          .bsdf_pdf = from.bsdf_pdf,
          .guide_pdf = from.guide_pdf};
}

// Equal to the bit, unless the test's own products are rounded in another order.
void ExpectSame(const FocalStatistics& recorded, const FocalStatistics& expected) {
  ASSERT_EQ(recorded.counts(), expected.counts());
  double total = 0;
  for (uint32_t slot = 0; slot < expected.slot_count(); ++slot) {
    const double value = expected.sum(slot).Value();
    ASSERT_NEAR(recorded.sum(slot).Value(), value, 1e-6 * value) << slot;
    total += value;
  }
  EXPECT_GT(total, 0);
}

const Vec3 kFirst{0.1f, 0.52f, 0.55f}, kSecond{0.4f, 0.52f, 0.55f};

TEST(FocalGuideRecord, ASegmentCountsByWhatItBringsToThePixel) {
  const FocalPath path;
  PathVertex first = Diffuse(kFirst, {1, 0, 0}, 2), second = Diffuse(kSecond, {0, 1, 0}, 0.3f);
  first.beta = {0.5f, 0.6f, 0.7f};
  first.roulette = 2;
  first.direct = Rgb(100);  // arrives before the first segment
  second.beta = first.beta * first.weight * first.roulette;
  second.direct = {1, 2, 3};
  second.emitted = Rgb(4);
  second.emission_weight = 0.25f;
  second.guide_pdf = 0.7f;
  const Rgb lamp = Lamp(0.2f).emitted * 0.5f;
  const Rgb from_second = second.emitted * 0.25f + second.direct + second.weight * lamp;
  ExpectSame(path.Recorded({first, second, Lamp(0.2f)}),
             path.Of({Segment(first, 0.3f, first.beta * first.weight * from_second * 2),
                      Segment(second, 0.2f, second.beta * second.weight * lamp)}));
}

TEST(FocalGuideRecord, WhereThePathEndedThereIsNoSegment) {
  const FocalPath path;
  PathVertex first = Diffuse(kFirst, {1, 0, 0}, 2), second = Diffuse(kSecond, {0, 1, 0}, 0.3f);
  second.direct = Rgb(3);
  second.roulette = 0;
  const FocalStatistics recorded = path.Recorded({first, second});
  EXPECT_EQ(recorded.counts().accepted, 1u);
  ExpectSame(recorded, path.Of({Segment(first, 0.3f, first.weight * second.direct)}));
}

TEST(FocalGuideRecord, BehindASmoothHitTheSegmentGoesOnStraight) {
  const PathVertex first = Diffuse(kFirst, {1, 0, 0}, 2);
  for (const float alpha : {0.0f, 0.29f, 0.31f, 1.0f}) {
    const PathVertex mirror = Mirror(0.3f, alpha);
    const Rgb brought = first.weight * mirror.weight * Lamp(1).emitted * 0.5f;
    for (const bool images : {true, false}) {
      const FocalPath path(images);
      const float distance = images && alpha < 0.3f ? kInfinity : 0.3f;
      ExpectSame(path.Recorded({first, mirror, Lamp(0.2f)}), path.Of({Segment(first, distance, brought)}));
    }
  }
}

TEST(FocalGuideRecord, PathsThatLeaveTheSceneGoToTheBoxesEdge) {
  const FocalPath path;
  const PathVertex first = Diffuse(kFirst, {1, 0, 0}, 2);
  ExpectSame(path.Recorded({first, Lamp(kInfinity)}),
             path.Of({Segment(first, kInfinity, first.weight * Lamp(1).emitted * 0.5f)}));
}

// ---- Grid guiding ----

using Learn = GridMethod::Learn;

struct Sums {
  double sum = 0;
  uint64_t count = 0;
};

class GridPath {
 public:
  // A table that has learned of the lower half of the box alone.
  GridPath() {
    GridStatistics records(RadianceGrid::Initial(kUnit, options_.grid));
    test::Random random(3);
    for (int i = 0; i < 50000; ++i) {
      Vec3 x = grid_testing::PointIn(kUnit, random);
      x.z *= 0.4f;
      const Vec3 w = grid_testing::UniformDirection(random);
      records.Record(records.grid()->CellAt(x), records.grid()->DirectionAt(w), grid_testing::RadianceIn(kUnit, x, w));
    }
    grid_ = Advance(*records.grid(), records);
  }

  const RadianceGrid& grid() const { return *grid_; }
  float MeanRadiance(Vec3 p, Vec3 n) const {
    return GridSampling(grid_, options_.rules).MeanRadiance(grid_->CellAt(p), GridHemispheres::NormalAt(n));
  }

  // A recorded vertex whose leaf is what the guide says of such a surface, seen from its normal.
  PathVertex Vertex(Learn learn, const Bsdf& bsdf, Vec3 p, Vec3 n, Vec3 wi) {
    SurfaceInteraction si{};
    si.p = p;
    si.shading = Frame::FromNormal(n);
    PathVertex vertex = Diffuse(p, wi, 0.3f);
    vertex.leaf = Guide(learn).At(si, bsdf, {0, 0, 1}).leaf;
    return vertex;
  }

  std::map<size_t, Sums> Recorded(Learn learn, const std::vector<PathVertex>& vertices) {
    GridGuidingStatistics statistics{GridStatistics(grid_)};
    GridGuide::Scratch scratch;
    Guide(learn).Record(vertices, {}, &scratch, &statistics);
    std::map<size_t, Sums> sums;
    statistics.sums().ForEach([&](size_t entry, const GridStatistics::Sum& sum) {
      sums[entry] = {sum.value.Value() / grid_->radiance_scale(), sum.count};
    });
    return sums;
  }
  size_t EntryOf(const PathVertex& vertex) const {
    return grid_->Entry(grid_->CellAt(vertex.p), grid_->DirectionAt(vertex.wi));
  }

 private:
  GridGuide Guide(Learn learn) {
    options_.learn = learn;
    return {grid_, options_};
  }

  GridMethod::Options options_ = [] {
    GridMethod::Options options;
    options.grid.cells = 2;
    return options;
  }();
  std::shared_ptr<const RadianceGrid> grid_;
};

const Bsdf kDiffuse = Bsdf::Diffuse(Rgb(0.5f)), kGlossy = Bsdf::Conductor(Rgb(0.2f), Rgb(3), {0.6f, 0.6f});
const Vec3 kUp{0, 0, 1}, kKnown{0.2f, 0.7f, 0.1f}, kUnknown{0.2f, 0.7f, 0.9f};

// A path of two recorded vertices and a lamp; the second shines and is lit.
struct TwoBounces {
  std::vector<PathVertex> vertices;
  Rgb lamp, own;

  TwoBounces(GridPath& path, Learn learn, const Bsdf& bsdf, Vec3 second) {
    vertices = {path.Vertex(learn, kDiffuse, {0.8f, 0.2f, 0.1f}, kUp, Normalize({0.1f, 0.2f, 0.9f})),
                path.Vertex(learn, bsdf, second, kUp, Normalize({-0.3f, 0.5f, 0.7f})), Lamp(0.2f)};
    vertices[0].roulette = 3;
    vertices[1].roulette = 2;
    vertices[1].emitted = Rgb(4);
    vertices[1].emission_weight = 0.25f;
    vertices[1].direct = {1, 2, 3};
    lamp = vertices[2].emitted * 0.5f;
    own = vertices[1].emitted * 0.25f + vertices[1].direct;
  }
};

void ExpectSums(const std::map<size_t, Sums>& recorded, const std::map<size_t, double>& expected) {
  ASSERT_EQ(recorded.size(), expected.size());
  for (const auto& [entry, value] : expected) {
    ASSERT_TRUE(recorded.contains(entry));
    EXPECT_EQ(recorded.at(entry).count, 1u);
    EXPECT_NEAR(recorded.at(entry).sum, value, 1e-5 * value);
  }
}

TEST(GridGuideRecord, MonteCarloIsWhatThePathBrought) {
  GridPath path;
  const TwoBounces two(path, Learn::kMonteCarlo, kDiffuse, kKnown);
  const Rgb from_second = two.own + two.vertices[1].weight * two.lamp * 2;
  ExpectSums(path.Recorded(Learn::kMonteCarlo, two.vertices),
             {{path.EntryOf(two.vertices[0]), 3 * Luminance(from_second)},
              {path.EntryOf(two.vertices[1]), 2 * Luminance(two.lamp)}});
}

// The table takes over behind the next vertex: what survival multiplied the path by does not count.
TEST(GridGuideRecord, SarsaIsTheNextLightAndTheTableInItsDirection) {
  GridPath path;
  const TwoBounces two(path, Learn::kSarsa, kDiffuse, kKnown);
  const float table = path.grid().Radiance(path.grid().CellAt(kKnown), path.grid().DirectionAt(two.vertices[1].wi));
  ASSERT_GT(table, 0);
  ExpectSums(path.Recorded(Learn::kSarsa, two.vertices),
             {{path.EntryOf(two.vertices[0]), Luminance(two.own + two.vertices[1].weight * table)},
              {path.EntryOf(two.vertices[1]), Luminance(two.lamp)}});
}

TEST(GridGuideRecord, ExpectedSarsaIsTheNextLightAndTheTablesMeanOverTheHemisphere) {
  GridPath path;
  const TwoBounces two(path, Learn::kExpectedSarsa, kDiffuse, kKnown);
  const float mean = path.MeanRadiance(kKnown, kUp);
  ASSERT_GT(mean, 0);
  ExpectSums(path.Recorded(Learn::kExpectedSarsa, two.vertices),
             {{path.EntryOf(two.vertices[0]), Luminance(two.own) + 0.5 * mean},
              {path.EntryOf(two.vertices[1]), Luminance(two.lamp)}});
  // Not of a surface that is more than diffuse: the hemisphere's mean times an albedo is not what that reflects.
  const TwoBounces glossy(path, Learn::kExpectedSarsa, kGlossy, kKnown);
  const float table = path.grid().Radiance(path.grid().CellAt(kKnown), path.grid().DirectionAt(two.vertices[1].wi));
  ASSERT_GT(std::fabs(0.5f * mean - Luminance(two.vertices[1].weight * table)), 0.01f * mean);
  ExpectSums(path.Recorded(Learn::kExpectedSarsa, glossy.vertices),
             {{path.EntryOf(two.vertices[0]), Luminance(two.own + two.vertices[1].weight * table)},
              {path.EntryOf(two.vertices[1]), Luminance(two.lamp)}});
}

// The hemisphere's mean asks nothing of the path: it counts where the path's own direction came to nothing, too.
TEST(GridGuideRecord, ExpectedSarsaKnowsWhatAPathThatDiedWouldHaveMet) {
  GridPath path;
  TwoBounces two(path, Learn::kExpectedSarsa, kDiffuse, kKnown);
  two.vertices.pop_back();
  two.vertices[1].weight = Rgb();
  two.vertices[1].recorded = false;
  const double mean = path.MeanRadiance(kKnown, kUp);
  ExpectSums(path.Recorded(Learn::kExpectedSarsa, two.vertices),
             {{path.EntryOf(two.vertices[0]), Luminance(two.own) + 0.5 * mean}});
}

TEST(GridGuideRecord, WhereTheTableKnowsNothingThePathTakesOver) {
  GridPath path;
  ASSERT_EQ(path.grid().Fluence(path.grid().CellAt(kUnknown)), 0);
  for (const Learn learn : {Learn::kSarsa, Learn::kExpectedSarsa}) {
    const TwoBounces two(path, learn, kDiffuse, kUnknown);
    const Rgb from_second = two.own + two.vertices[1].weight * two.lamp * 2;
    ExpectSums(path.Recorded(learn, two.vertices), {{path.EntryOf(two.vertices[0]), Luminance(from_second)},
                                                    {path.EntryOf(two.vertices[1]), Luminance(two.lamp)}});
  }
}

// Roulette makes up for the paths that it ends, which Monte Carlo has to count as zero. The other rules have not seen
// what arrives there, but know what the vertex reflects all the same.
TEST(GridGuideRecord, APathThatRouletteEnded) {
  GridPath path;
  for (const Learn learn : {Learn::kMonteCarlo, Learn::kSarsa, Learn::kExpectedSarsa}) {
    TwoBounces two(path, learn, kDiffuse, kKnown);
    two.vertices.pop_back();
    two.vertices[1].roulette = 0;
    const auto recorded = path.Recorded(learn, two.vertices);
    const size_t first = path.EntryOf(two.vertices[0]), second = path.EntryOf(two.vertices[1]);
    ASSERT_TRUE(recorded.contains(first));
    const double own = Luminance(two.own);
    if (learn == Learn::kMonteCarlo) {
      ASSERT_TRUE(recorded.contains(second));
      EXPECT_EQ(recorded.at(second).sum, 0);
      EXPECT_NEAR(recorded.at(first).sum, 3 * own, 1e-5 * own);
    } else {
      EXPECT_FALSE(recorded.contains(second));
      EXPECT_GT(recorded.at(first).sum, 1.01 * own);
    }
  }
}

// Mirrors are followed along the path: its own light counts, and its own survival.
TEST(GridGuideRecord, DeltaLobesAreFollowed) {
  GridPath path;
  for (const Learn learn : {Learn::kMonteCarlo, Learn::kSarsa, Learn::kExpectedSarsa}) {
    const PathVertex first = path.Vertex(learn, kDiffuse, {0.8f, 0.2f, 0.1f}, kUp, Normalize({0.1f, 0.2f, 0.9f}));
    PathVertex mirror = Mirror(0.3f, 0);
    mirror.roulette = 2;
    const Rgb arriving = mirror.weight * Lamp(1).emitted * (0.5f * 2);
    ExpectSums(path.Recorded(learn, {first, mirror, Lamp(0.4f)}), {{path.EntryOf(first), Luminance(arriving)}});
  }
}

}  // namespace
}  // namespace lodestar
