#include "core/guiding/focal_octree.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/guiding/focal_testing.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using focal_testing::PointIn;
using focal_testing::Random;
using focal_testing::RandomField;
using focal_testing::UniformDirection;

const Bounds3 kUnit{{0, 0, 0}, {1, 1, 1}};

struct Piece {
  float t0, t1;
};

// The pieces of a ray, in its order.
std::vector<Piece> Pieces(const FocalOctree& octree, Vec3 x, Vec3 w, float end = kInfinity) {
  std::vector<Piece> pieces;
  octree.ForVoxels(FocalRay(x, w), end, [&](uint32_t, float t0, float t1, float) { pieces.push_back({t0, t1}); });
  std::sort(pieces.begin(), pieces.end(), [](Piece a, Piece b) { return a.t0 < b.t0; });
  return pieces;
}

void ExpectTiled(const std::vector<Piece>& pieces, float end) {
  ASSERT_FALSE(pieces.empty());
  EXPECT_EQ(pieces.front().t0, 0);
  for (size_t i = 1; i < pieces.size(); ++i) ASSERT_EQ(pieces[i].t0, pieces[i - 1].t1) << i;
  EXPECT_EQ(pieces.back().t1, end);
}

// Where the ray leaves the unit cube, as the walk computes it.
float Exit(Vec3 x, Vec3 w) {
  float t = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const float d = std::fabs(w[axis]) < 1e-18f ? std::copysign(1e-18f, w[axis]) : w[axis];
    t = std::min(t, ((std::signbit(d) ? 0 : 1) - x[axis]) * (1 / d));
  }
  return t;
}

// What Integrate() adds up, over the pieces that ForVoxels() finds.
double SumOverPieces(const FocalOctree& octree, Vec3 x, Vec3 w) {
  double sum = 0;
  octree.ForVoxels(FocalRay(x, w), kInfinity, [&](uint32_t, float t0, float t1, float density) {
    const double a = t0, b = t1;
    sum += density * ((b - a) * (b * b + b * a + a * a));
  });
  return sum;
}

struct Naive {
  double integral = 0;
  double rounding = 0;       // that the walk in floats may be off by
  std::set<uint32_t> nodes;  // with a voxel on the ray
};
Naive IntegrateNaively(const FocalOctree& octree, Vec3 x, Vec3 w) {
  Naive naive;
  const double origin[] = {x.x, x.y, x.z}, direction[] = {w.x, w.y, w.z};
  focal_testing::WalkNaively(octree, 0, {0, 0, 0}, 1, origin, direction, 1e30,
                             [&](uint32_t slot, double t0, double t1, float density) {
                               naive.integral += density * (t1 * t1 * t1 - t0 * t0 * t0);
                               naive.rounding += density * 3 * t1 * t1 * 2e-6;  // a few roundings of each end
                               naive.nodes.insert(slot / 8);
                             });
  return naive;
}

// Split down to `depth` levels along the cube's diagonal, a voxel to either side included, with uneven masses.
FocalOctree AlongTheDiagonal(int depth) {
  struct Cube {
    Vec3 lower;
    float size;
  };
  std::vector<uint8_t> inner;
  std::vector<float> masses;
  std::vector<Cube> cubes = {{{0, 0, 0}, 1}};
  Random random(6);
  for (size_t i = 0; i < cubes.size(); ++i) {
    const Cube cube = cubes[i];
    const float half = cube.size / 2;
    inner.push_back(0);
    for (int c = 0; c < 8; ++c) {
      const Vec3 octant{static_cast<float>(c & 1), static_cast<float>(c >> 1 & 1), static_cast<float>(c >> 2)};
      const Vec3 lower = cube.lower + octant * half, middle = lower + Vec3{1, 1, 1} * (half / 2);
      const float along = (middle.x + middle.y + middle.z) / 3;
      if (half > std::ldexp(1.0f, -depth) && Length(middle - Vec3{along, along, along}) < 1.5f * half) {
        inner.back() |= static_cast<uint8_t>(1 << c);
        cubes.push_back({lower, half});
      } else {
        masses.push_back(static_cast<float>(std::pow(10.0, -3 * random.Next1D())));
      }
    }
  }
  return FocalOctree::From(inner, masses).value();
}

TEST(FocalOctree, VoxelsTileTheRayExactly) {
  Random random(1);
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const auto field = RandomField(kUnit, 3 + static_cast<int>(seed), seed);
    const FocalOctree& octree = field->octrees()[0];
    for (int i = 0; i < 3000; ++i) {
      const Vec3 x = PointIn(kUnit, random), w = UniformDirection(random);
      ExpectTiled(Pieces(octree, x, w), Exit(x, w));
      const float end = 0.3f * random.Next1D() + 1e-3f;
      if (end < Exit(x, w)) ExpectTiled(Pieces(octree, x, w, end), end);
    }
  }
}

TEST(FocalOctree, RaysInFacesAlongEdgesAndThroughCornersAreTiled) {
  const auto field = RandomField(kUnit, 7, 5);
  const FocalOctree& octree = field->octrees()[0];
  Random random(2);
  const float kPlanes[] = {0, 0.125f, 0.25f, 0.5f, 0.75f, 1 - 0x1p-7f};
  const float kComponents[] = {0, -0.0f, 1, -1, 1e-30f, -1e-20f};
  for (int i = 0; i < 20000; ++i) {
    Vec3 x = PointIn(kUnit, random), w;
    for (int axis = 0; axis < 3; ++axis) {
      if (random.Next1D() < 0.7f) x[axis] = kPlanes[random.Next() % 6];
      w[axis] = kComponents[random.Next() % 6];
    }
    if (!(LengthSquared(w) > 0.5f)) continue;
    w = Normalize(w);
    // From a face outwards there is nothing to walk through.
    if (!(Exit(x, w) > 0)) continue;
    ExpectTiled(Pieces(octree, x, w), Exit(x, w));
    const double sum = SumOverPieces(octree, x, w);
    ASSERT_NEAR(octree.Integrate(FocalRay(x, w)), sum, 1e-5 * sum);
  }
}

TEST(FocalOctree, AgreesWithTheRecursiveWalk) {
  Random random(3);
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const auto field = RandomField(kUnit, 4 + static_cast<int>(seed), seed, 3);
    const FocalOctree& octree = field->octrees()[0];
    for (int i = 0; i < 4000; ++i) {
      const Vec3 x = PointIn(kUnit, random), w = UniformDirection(random);
      const Naive naive = IntegrateNaively(octree, x, w);
      ASSERT_NEAR(octree.Integrate(FocalRay(x, w)), naive.integral, 1e-5 * naive.integral + naive.rounding);
    }
  }
}

// Such a ray crosses more nodes than Walk() keeps in a row: it goes on with the newest.
TEST(FocalOctree, ALongRayThroughADeepOctreeIsWalkedWhole) {
  constexpr size_t kFull = 448;  // as Walk() has it
  const FocalOctree octree = AlongTheDiagonal(9);
  // Near enough to the diagonal for every voxel on the way to be of the deepest level.
  const Bounds3 first{{0, 0, 0}, {0.002f, 0.002f, 0.002f}}, last{{0.998f, 0.998f, 0.998f}, {1, 1, 1}};
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Vec3 near = PointIn(first, random), far = PointIn(last, random);
    const Vec3 x = i % 2 ? far : near, w = Normalize(i % 2 ? near - far : far - near);
    const Naive naive = IntegrateNaively(octree, x, w);
    ASSERT_GT(naive.nodes.size(), kFull + 100);
    ExpectTiled(Pieces(octree, x, w), Exit(x, w));
    const float end = 0.9f * Exit(x, w);
    ExpectTiled(Pieces(octree, x, w, end), end);
    const double sum = SumOverPieces(octree, x, w);
    ASSERT_NEAR(octree.Integrate(FocalRay(x, w)), sum, 1e-5 * sum);
    ASSERT_NEAR(sum, naive.integral, 1e-5 * naive.integral + naive.rounding);
  }
}

TEST(FocalOctree, ChoosesVoxelsByTheirMass) {
  const auto field = RandomField(kUnit, 6, 4, 2);
  const FocalOctree& octree = field->octrees()[0];
  Random random(4);
  std::vector<double> observed(octree.node_count() * 8), expected(octree.node_count() * 8);
  constexpr int kSamples = 400000;
  for (int i = 0; i < kSamples; ++i) {
    const FocalOctree::Voxel voxel = octree.Choose(random.Next1D() * octree.mass());
    ASSERT_EQ((octree.node(voxel.slot / 8).inner >> (voxel.slot % 8)) & 1, 0);
    ASSERT_GT(octree.mass(voxel.slot), 0);
    ++observed[voxel.slot];
  }
  for (uint32_t slot = 0; slot < expected.size(); ++slot)
    if (((octree.node(slot / 8).inner >> (slot % 8)) & 1) == 0)
      expected[slot] = kSamples * (octree.mass(slot) / octree.mass());
  const test::TestResult result = test::ChiSquareTest(observed, expected, 1e-3);
  EXPECT_TRUE(result.accepted) << result.message;
  std::swap(expected[9], *std::max_element(expected.begin(), expected.end()));
  EXPECT_FALSE(test::ChiSquareTest(observed, expected, 1e-3).accepted);
}

TEST(FocalOctree, TheChosenVoxelIsWhereTheWalkHasIt) {
  const auto field = RandomField(kUnit, 9, 8);
  const FocalOctree& octree = field->octrees()[0];
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const FocalOctree::Voxel voxel = octree.Choose(random.Next1D() * octree.mass());
    const Vec3 x = PointIn(kUnit, random), middle = voxel.lower + Vec3{1, 1, 1} * (voxel.size / 2);
    const FocalRay ray(x, Normalize(middle - x));
    ASSERT_TRUE(octree.Crosses(ray, voxel));
    bool met = false;
    octree.ForVoxels(ray, kInfinity, [&](uint32_t slot, float, float, float) { met |= slot == voxel.slot; });
    ASSERT_TRUE(met);
  }
}

TEST(FocalOctree, BrokenShapesAreRefused) {
  const std::vector<float> eight(8, 0.125f), fifteen(15, 0.1f);
  const auto made = [](std::vector<uint8_t> inner, const std::vector<float>& masses) {
    return FocalOctree::From(inner, masses).has_value();
  };
  EXPECT_TRUE(made({0}, eight));
  EXPECT_TRUE(made({4, 0}, fifteen));
  EXPECT_FALSE(made({}, {}));
  EXPECT_FALSE(made({0}, fifteen));     // more masses than leaves
  EXPECT_FALSE(made({0, 0}, fifteen));  // a node that no octant leads to
  EXPECT_FALSE(made({4}, eight));       // an octant that leads nowhere
  std::vector<uint8_t> chain(FocalOctree::kMaxDepth, 1);
  chain.back() = 0;
  std::vector<float> masses(7 * chain.size() + 1, 0.01f);
  EXPECT_TRUE(made(chain, masses));
  chain.insert(chain.begin(), 1);  // one level too deep
  masses.resize(masses.size() + 7, 0.01f);
  EXPECT_FALSE(made(chain, masses));
}

}  // namespace
}  // namespace lodestar
