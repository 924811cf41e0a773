#include "core/guiding/focal_octree.h"

#include <gtest/gtest.h>

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
    ASSERT_TRUE(std::isfinite(octree.Integrate(FocalRay(x, w))));
  }
}

TEST(FocalOctree, AgreesWithTheRecursiveWalk) {
  Random random(3);
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const auto field = RandomField(kUnit, 4 + static_cast<int>(seed), seed, 3);
    const FocalOctree& octree = field->octrees()[0];
    for (int i = 0; i < 4000; ++i) {
      const Vec3 x = PointIn(kUnit, random), w = UniformDirection(random);
      const double origin[] = {x.x, x.y, x.z}, direction[] = {w.x, w.y, w.z};
      double expected = 0, scale = 0;
      focal_testing::WalkNaively(octree, 0, {0, 0, 0}, 1, origin, direction, 1e30,
                                 [&](uint32_t, double t0, double t1, float density) {
                                   expected += density * (t1 * t1 * t1 - t0 * t0 * t0);
                                   scale += density * 3 * t1 * t1 * 2e-6;  // a few roundings of each end
                                 });
      ASSERT_NEAR(octree.Integrate(FocalRay(x, w)), expected, 1e-5 * expected + scale);
    }
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
