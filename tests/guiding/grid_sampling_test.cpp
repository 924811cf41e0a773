// The five sampling rules: directions follow their density, densities integrate to one (the document's memo's do not),
// and nothing lies below the surface on the hemisphere.
#include "core/guiding/grid_sampling.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/guiding/grid_bias.h"
#include "tests/guiding/grid_testing.h"

namespace lodestar {
namespace {

using namespace grid_testing;
using Sampling = GridRules::Sampling;

constexpr Sampling kAll[] = {Sampling::kInversionSphere, Sampling::kInversionHemisphere, Sampling::kRejection,
                             Sampling::kRejectionMixed, Sampling::kMetropolis};
const Vec3 kNormals[] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, Normalize({0.3f, -0.8f, 0.52f}), Normalize({-1, 1, -1e-4f})};
const Vec3 kPoint{0.4f, 0.2f, 0.3f};
// Rules x normals x kinds of bins, and a few more.
const double kLevel = test::SidakLevel(0.01, 60);

const std::shared_ptr<const RadianceGrid>& Trained() {
  static const auto kGrid = Train({.cells = 2});
  return kGrid;
}

// Bins of the whole sphere in world space, the density integrated over each at 64 x 64 points: it jumps, so quadrature
// would not do.
test::TestResult ChiSquareInWorld(const GridSampling& sampling, Vec3 n, uint64_t seed) {
  constexpr int kRows = 12, kColumns = 24, kPoints = 64, kSamples = 20000;
  const GridSampling::Local local = sampling.At(sampling.grid().CellAt(kPoint), n);
  std::vector<double> observed(kRows * kColumns), expected(observed.size());
  for (int i = 0; i < kRows * kPoints; ++i)
    for (int j = 0; j < kColumns * kPoints; ++j) {
      const Vec2 at{(static_cast<float>(i) + 0.5f) / (kRows * kPoints),
                    (static_cast<float>(j) + 0.5f) / (kColumns * kPoints)};
      expected[static_cast<size_t>(i / kPoints * kColumns + j / kPoints)] +=
          sampling.Pdf(local, CylindricalToDirection(at)) * (4 * 3.14159265358979 * kSamples) /
          (static_cast<double>(observed.size()) * kPoints * kPoints);
    }
  Random random(seed);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 u = random.Next2D();
    const Vec2 at = DirectionToCylindrical(sampling.Sample(local, u, random.Next1D()).w);
    ++observed[static_cast<size_t>(at.x * kRows) * kColumns + static_cast<size_t>(at.y * kColumns)];
  }
  return test::ChiSquareTest(observed, expected, kLevel);
}

// Bins that quarter the cells of what is sampled, in which the density is even: many samples can be held against it.
test::TestResult ChiSquareInCells(const GridSampling& sampling, Vec3 n, uint64_t seed, double factor = 1,
                                  const GridSampling* density = nullptr) {
  constexpr int kSamples = 200000;
  const bool sphere = sampling.rules().on_sphere();
  const int side = 2 * sampling.grid().options().directions, columns = sphere ? 2 * side : side;
  const GridSampling::Local local = sampling.At(sampling.grid().CellAt(kPoint), n);
  const GridSampling& other = density != nullptr ? *density : sampling;
  const GridSampling::Local other_local = other.At(sampling.grid().CellAt(kPoint), n);
  std::vector<double> observed(static_cast<size_t>(side * columns)), expected(observed.size());
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < columns; ++j) {
      const Vec2 at{(static_cast<float>(i) + 0.5f) / static_cast<float>(side),
                    (static_cast<float>(j) + 0.5f) / static_cast<float>(columns)};
      const Vec3 in_frame = HemisphereToDirection(at);
      const Vec3 w = sphere ? CylindricalToDirection(at) : local.frame.ToWorld(in_frame);
      const double even = sphere ? kUniformSpherePdf : in_frame.z * kInvPi;
      expected[static_cast<size_t>(i * columns + j)] =
          factor * kSamples * other.Pdf(other_local, w) / even / static_cast<double>(observed.size());
    }
  Random random(seed);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 u = random.Next2D();
    const Vec3 w = sampling.Sample(local, u, random.Next1D()).w;
    const Vec2 at = sphere ? DirectionToCylindrical(w) : DirectionToHemisphere(local.frame.ToLocal(w));
    ++observed[static_cast<size_t>(at.x * static_cast<float>(side)) * static_cast<size_t>(columns) +
               static_cast<size_t>(at.y * static_cast<float>(columns))];
  }
  return test::ChiSquareTest(observed, expected, kLevel);
}

TEST(GridSampling, DirectionsFollowTheDensity) {
  uint64_t seed = 1;
  for (const Sampling rule : kAll) {
    const GridSampling sampling(Trained(), {.sampling = rule});
    for (const Vec3 n : kNormals) {
      const test::TestResult world = ChiSquareInWorld(sampling, n, seed++),
                             cells = ChiSquareInCells(sampling, n, seed++);
      EXPECT_TRUE(world.accepted) << static_cast<int>(rule) << ": " << world.message;
      EXPECT_TRUE(cells.accepted) << static_cast<int>(rule) << ": " << cells.message;
    }
  }
}

TEST(GridSampling, AWrongDensityIsSeen) {
  const GridSampling sampling(Trained(), {.sampling = Sampling::kInversionHemisphere});
  const GridSampling mixed(Trained(), {.sampling = Sampling::kRejectionMixed, .mix = 0.05f});
  const GridSampling chain(Trained(), {.sampling = Sampling::kMetropolis});
  EXPECT_TRUE(ChiSquareInCells(sampling, kNormals[0], 1).accepted);
  EXPECT_FALSE(ChiSquareInCells(sampling, kNormals[0], 1, 0.95).accepted);
  EXPECT_FALSE(ChiSquareInCells(sampling, kNormals[0], 1, 1.05).accepted);
  EXPECT_FALSE(ChiSquareInCells(sampling, kNormals[0], 1, 1, &mixed).accepted);
  // The chain has not reached the table: its own distribution is another.
  EXPECT_FALSE(ChiSquareInCells(chain, kNormals[0], 1, 1, &sampling).accepted);
}

double Integral(const GridSampling& sampling, Vec3 n) {
  const GridSampling::Local local = sampling.At(sampling.grid().CellAt(kPoint), n);
  double sum = 0;
  constexpr int kSide = 1500;
  for (int i = 0; i < kSide * kSide; ++i)
    sum += sampling.Pdf(local, CylindricalToDirection({(static_cast<float>(i / kSide) + 0.5f) / kSide,
                                                       (static_cast<float>(i % kSide) + 0.5f) / kSide}));
  return sum * 4 * 3.14159265358979 / (kSide * kSide);
}

TEST(GridSampling, DensitiesIntegrateToOne) {
  for (const Sampling rule : kAll) {
    const GridSampling sampling(Trained(), {.sampling = rule});
    for (const Vec3 n : {kNormals[1], kNormals[3]}) EXPECT_NEAR(Integral(sampling, n), 1, 2e-3);
  }
}

// The document's normalisation is of the middle of a cell of normals, summed over the middles of the table's cells.
TEST(GridSampling, ThoseOfTheMemoDoNot) {
  const auto coarse = Train({.cells = 2, .directions = 4});
  for (const Sampling rule : {Sampling::kRejection, Sampling::kRejectionMixed}) {
    const GridSampling memo(Trained(), {.sampling = rule, .memo = true});
    double worst = 0;
    for (const Vec3 n : kNormals) worst = std::max(worst, std::fabs(Integral(memo, n) - 1));
    EXPECT_GT(worst, 0.01);
    EXPECT_GT(std::fabs(Integral(GridSampling(coarse, {.sampling = rule, .memo = true}), kNormals[3]) - 1), 0.02);
  }
}

TEST(GridBias, IsMeasuredOverVoxelsAndNormals) {
  const auto coarse = Train({.cells = 2, .directions = 4});
  // With the least that a quadrature leaves of an exact density.
  const auto exact = MeasureIntegrals(GridSampling(coarse, {.sampling = Sampling::kRejection}));
  ASSERT_TRUE(exact);
  EXPECT_NEAR(exact->mean, 1, 1e-4);
  EXPECT_LT(exact->spread, 1e-3);
  const GridSampling memo(coarse, {.sampling = Sampling::kRejection, .memo = true});
  const auto biased = MeasureIntegrals(memo);
  ASSERT_TRUE(biased);
  EXPECT_GT(biased->spread, 0.02);
  double sum = 0;
  Random random(5);
  constexpr int kNormals = 10;
  for (int i = 0; i < kNormals; ++i) sum += Integral(memo, UniformDirection(random));
  // One voxel of eight, and ten normals: what the spread lets expect.
  EXPECT_NEAR(biased->mean, sum / kNormals, 4 * biased->spread / std::sqrt(kNormals));
  // Mixed with even directions, it is as much less biased as there are of those.
  const auto mixed =
      MeasureIntegrals(GridSampling(coarse, {.sampling = Sampling::kRejectionMixed, .memo = true, .mix = 0.5f}));
  ASSERT_TRUE(mixed);
  EXPECT_NEAR(mixed->spread, 0.5 * biased->spread, 1e-3);
  EXPECT_FALSE(MeasureIntegrals(
      GridSampling(RadianceGrid::Initial(kUnit, {}), {.sampling = Sampling::kRejection, .memo = true})));
}

TEST(GridSampling, SampledPdfIsThePdfOfTheDirectionAndNothingLiesBelow) {
  Random random(2);
  for (const Sampling rule : kAll)
    for (const bool memo : {false, true}) {
      if (memo && rule != Sampling::kRejection && rule != Sampling::kRejectionMixed) continue;
      const GridSampling sampling(Trained(), {.sampling = rule, .memo = memo});
      int below = 0;
      for (int i = 0; i < (rule == Sampling::kInversionHemisphere ? 300000 : 5000); ++i) {
        const Vec3 n = UniformDirection(random);
        const auto local = sampling.At(Trained()->CellAt(PointIn(kUnit, random)), n);
        ASSERT_TRUE(local.usable);
        const Vec2 u = random.Next2D();
        const GuidedSample s = sampling.Sample(local, u, random.Next1D());
        ASSERT_NEAR(Length(s.w), 1, 1e-5);
        ASSERT_GT(s.pdf, 0);
        ASSERT_EQ(s.pdf, sampling.Pdf(local, s.w));
        below += Dot(n, s.w) <= 0;
      }
      EXPECT_EQ(below > 0, rule == Sampling::kInversionSphere);
    }
}

// For a diffuse surface radiance * cosine / density should be even where the table knows the radiance.
TEST(GridSampling, TheHemisphereIsTheProductWithTheCosine) {
  const auto product_variance = [](Sampling rule) {
    const GridSampling sampling(Trained(), {.sampling = rule});
    Random random(3);
    double relative = 0;
    for (int trial = 0; trial < 40; ++trial) {
      const Vec3 n = UniformDirection(random);
      const uint32_t cell = Trained()->CellAt(PointIn(kUnit, random));
      const auto local = sampling.At(cell, n);
      test::Moments moments;
      for (int i = 0; i < 2000; ++i) {
        const Vec2 u = random.Next2D();
        const GuidedSample s = sampling.Sample(local, u, random.Next1D());
        moments.Add(Trained()->Radiance(cell, Trained()->DirectionAt(s.w)) * std::max(Dot(n, s.w), 0.0f) / s.pdf);
      }
      relative += moments.variance() / (moments.mean() * moments.mean()) / 40;
    }
    return relative;
  };
  const double sphere = product_variance(Sampling::kInversionSphere);
  const double hemisphere = product_variance(Sampling::kInversionHemisphere);
  EXPECT_LT(hemisphere, 0.5 * sphere);
}

TEST(GridSampling, TheMeanRadianceIsTheIrradianceOverPi) {
  const GridSampling sampling(Trained(), {});
  const uint32_t cell = Trained()->CellAt(kPoint);
  for (uint32_t normal = 0; normal < GridHemispheres::kNormals; normal += 17) {
    const Vec3 n = GridHemispheres::NormalCenter(normal);
    ASSERT_EQ(GridHemispheres::NormalAt(n), normal);
    double sum = 0;
    constexpr int kSide = 400;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec3 w = CylindricalToDirection(
          {(static_cast<float>(i / kSide) + 0.5f) / kSide, (static_cast<float>(i % kSide) + 0.5f) / kSide});
      sum += Trained()->Radiance(cell, Trained()->DirectionAt(w)) * std::max(Dot(n, w), 0.0f);
    }
    EXPECT_NEAR(sampling.MeanRadiance(cell, normal) / (sum * 4 / (kSide * kSide)), 1, 0.1) << normal;
  }
}

TEST(GridSampling, NormalsAreNearTheirCells) {
  Random random(4);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 n = UniformDirection(random);
    const uint32_t normal = GridHemispheres::NormalAt(n);
    ASSERT_LT(normal, GridHemispheres::kNormals);
    ASSERT_GT(Dot(n, GridHemispheres::NormalCenter(normal)), 0.978f);  // 12 degrees
    const Frame frame = GridHemispheres::Of(16).FrameOf(normal, n);
    ASSERT_NEAR(Dot(Cross(frame.s, frame.t), n), 1, 1e-5);
  }
}

// What is remembered must not show: nor whether there was room for it.
TEST(GridSampling, AFullMemoryChangesNothing) {
  GridMemo<float, 4> memo(3, 2);
  for (int round = 0; round < 2; ++round)
    for (uint32_t block = 0; block < 3; ++block)
      for (uint32_t slot = 0; slot < 4; ++slot) {
        std::unique_ptr<const float> own;
        const float* value = memo.Get(block, slot, &own, [&] { return static_cast<float>(10 * block + slot); });
        EXPECT_EQ(*value, static_cast<float>(10 * block + slot));
        EXPECT_EQ(own != nullptr, block > 0 || slot > 1);
      }
}

// Half of them come the other way, so that what is kept of a place is not always made by the same visitor.
TEST(GridSampling, ThreadsThatMeetTheSamePlacesAgree) {
  constexpr int kThreads = 4, kQueries = 4000;
  struct Query {
    Vec3 n, w, p;
  };
  Random random(6);
  std::vector<Query> queries(kQueries);
  for (Query& query : queries) query = {UniformDirection(random), UniformDirection(random), PointIn(kUnit, random)};
  const auto densities = [&](const GridSampling& sampling, bool backwards) {
    std::vector<float> found(kQueries);
    for (int i = 0; i < kQueries; ++i) {
      const int at = backwards ? kQueries - 1 - i : i;
      const auto local = sampling.At(Trained()->CellAt(queries[at].p), queries[at].n);
      found[at] = sampling.Pdf(local, queries[at].w);
    }
    return found;
  };
  std::vector<GridRules> all = {{.sampling = Sampling::kRejection, .memo = true},
                                {.sampling = Sampling::kRejectionMixed, .memo = true}};
  for (const Sampling rule : kAll) all.push_back({.sampling = rule});
  for (const GridRules& rules : all) {
    const std::vector<float> expected = densities(GridSampling(Trained(), rules), false);
    const GridSampling shared(Trained(), rules);
    std::vector<std::vector<float>> found(kThreads);
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i) threads.emplace_back([&, i] { found[i] = densities(shared, i % 2 != 0); });
    for (std::thread& thread : threads) thread.join();
    for (const auto& of_thread : found)
      EXPECT_EQ(of_thread, expected) << static_cast<int>(rules.sampling) << (rules.memo ? ", memo" : "");
  }
}

TEST(GridSampling, DarkBrightAndSingleEntriesStaySound) {
  Random random(5);
  for (const float emission : {1e-12f, 1e12f}) {
    const auto grid = Train({.cells = 2}, kUnit, 20000, emission);
    for (const Sampling rule : kAll) {
      const GridSampling sampling(grid, {.sampling = rule});
      for (int i = 0; i < 500; ++i) {
        const auto local = sampling.At(grid->CellAt(PointIn(kUnit, random)), UniformDirection(random));
        ASSERT_TRUE(local.usable);
        const GuidedSample s = sampling.Sample(local, random.Next2D(), random.Next1D());
        ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0 && IsFinite(s.w));
      }
    }
  }
  // One bright entry and nothing else; and a grid that knows only darkness.
  for (const float value : {1.0f, 0.0f}) {
    auto grid = RadianceGrid::Initial(kUnit, {.cells = 1, .prior = 0});
    GridStatistics statistics(grid);
    statistics.Record(0, grid->DirectionAt(Normalize({1, 2, 3})), value);
    grid = Advance(*grid, statistics);
    for (const Sampling rule : kAll) {
      const GridSampling sampling(grid, {.sampling = rule});
      const auto local = sampling.At(0, {0, 0, 1});
      ASSERT_EQ(local.usable, value > 0);
      if (!local.usable) continue;
      for (int i = 0; i < 500; ++i) {
        const GuidedSample s = sampling.Sample(local, random.Next2D(), random.Next1D());
        ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0);
      }
      EXPECT_EQ(sampling.At(0, {0, 0, -1}).usable, rule == Sampling::kInversionSphere);
    }
  }
}

}  // namespace
}  // namespace lodestar
