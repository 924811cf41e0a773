// What pictures of guides show: densities that integrate to 1, the right way round, leaves and projections where they
// are.
#include "core/guiding/guide_picture.h"

#include <gtest/gtest.h>

#include "core/guiding/guide_picture_space.h"
#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

TEST(GuidePicture, ATreesPictureIntegratesToOneAndEqualsItsDensity) {
  synthetic::Training training;
  const auto tree = synthetic::Train(training, 3);
  const uint32_t leaf = tree->LeafAt({0.3f, 0.4f, 0.9f});
  ASSERT_GT(tree->leaf(leaf).depth, 4);
  for (const int level : {3, 6, 9}) {
    const FloatGrid grid = DrawDirectionalTree(tree->Tree(leaf), level);
    ASSERT_EQ(grid.width, 1u << level);
    EXPECT_NEAR(IntegrateSphere(SphereMap::kCylindrical, grid), 1, 1e-5) << level;
  }
  // Where pixels are no larger than cells, a pixel's mean is its centre's density.
  const FloatGrid grid = DrawDirectionalTree(tree->Tree(leaf), 10);
  ASSERT_LE(tree->leaf(leaf).depth, 10);
  for (uint32_t y = 3; y < 1024; y += 41) {
    for (uint32_t x = 5; x < 1024; x += 37) {
      const Vec2 square{1 - (static_cast<float>(y) + 0.5f) / 1024, (static_cast<float>(x) + 0.5f) / 1024};
      EXPECT_NEAR(grid.At(x, y), directional::Locate(tree->Tree(leaf), square).density, 1e-5f * grid.At(x, y))
          << x << "," << y;
    }
  }
}

TEST(GuidePicture, BothMapsIntegrateADensityToOne) {
  const auto lobe = [](Vec3 w) { return std::max(0.0f, Dot(w, Normalize(Vec3{1, -2, 0.5f}))) * kInvPi; };
  for (const SphereMap map : {SphereMap::kCylindrical, SphereMap::kLatLong}) {
    EXPECT_NEAR(IntegrateSphere(map, DrawSphere(map, 128, lobe)), 1, 1e-3);
    const FloatGrid even = DrawSphere(map, 16, [](Vec3) { return kUniformSpherePdf; });
    for (const float value : even.values) EXPECT_NEAR(value, kUniformSpherePdf, 1e-6f);
    // The measure is not taken for granted: a density over the square would not integrate to 1 over the sphere.
    EXPECT_GT(IntegrateSphere(map, DrawSphere(map, 128, [&](Vec3 w) { return lobe(w) * 4 * kPi; })), 12);
  }
}

TEST(GuidePicture, UpIsZAndTheLeftEdgeIsX) {
  const auto around = [](Vec3 axis) { return [axis](Vec3 w) { return Exp(50 * (Dot(w, axis) - 1)); }; };
  for (const SphereMap map : {SphereMap::kCylindrical, SphereMap::kLatLong}) {
    const FloatGrid up = DrawSphere(map, 64, around({0, 0, 1})), y = DrawSphere(map, 64, around({0, 1, 0})),
                    x = DrawSphere(map, 64, around({1, 0, 0}));
    EXPECT_GT(up.At(10, 0), 100 * up.At(10, 32));
    EXPECT_GT(y.At(y.width / 4, 32), 100 * y.At(3 * y.width / 4, 32));
    EXPECT_GT(x.At(0, 32), 100 * x.At(x.width / 2, 32));
    EXPECT_GT(x.At(x.width - 1, 32), 100 * x.At(x.width / 4, 32));
  }
}

TEST(GuidePicture, ASliceShowsTheLeavesOfItsPlane) {
  synthetic::Training training;
  training.options.spatial_threshold = 500;
  const auto tree = synthetic::Train(training, 4);
  ASSERT_GT(tree->leaf_count(), 20u);
  const Vec3 p{0.3f, 0.6f, 0.2f};
  for (int axis = 0; axis < 3; ++axis) {
    const LeafPicture picture = DrawLeaves(tree->spatial(), axis, p, {{0, 0, 0}, {1, 1, 0.5f}}, 100);
    EXPECT_EQ(picture.width, 100u);
    EXPECT_EQ(picture.height, axis == 2 ? 100u : 50u);
    const auto x = static_cast<uint32_t>(p[RightAxis(axis)] * 100);
    const float height = axis == 2 ? 1 : 0.5f;
    const auto y = static_cast<uint32_t>((height - p[UpAxis(axis)]) * 100);
    EXPECT_EQ(picture.At(x, y), tree->LeafAt(p)) << axis;
    // A border is where the leaf changes, and nowhere else.
    size_t borders = 0;
    for (uint32_t i = 0; i + 1 < picture.width; ++i) {
      borders += picture.Border(i, 0);
      if (picture.At(i, 0) != picture.At(i + 1, 0)) {
        EXPECT_TRUE(picture.Border(i, 0));
      }
    }
    EXPECT_GT(borders, 0u);
    EXPECT_LT(borders, picture.width / 2);
    EXPECT_EQ(picture.Of([](uint32_t leaf) { return static_cast<float>(leaf); }).At(x, y),
              static_cast<float>(tree->LeafAt(p)));
  }
}

TEST(GuidePicture, ASegmentAddsToItsPixelsOnce) {
  const Bounds3 window{{0, 0, 0}, {4, 2, 1}};
  FloatGrid grid = EmptyPicture(window.Diagonal(), 2, 40);  // 40 x 20
  AddSegment({0.05f, 0.05f, 0.5f}, {3.95f, 0.05f, 0.9f}, 1, window, 2, &grid);
  for (uint32_t x = 1; x < 39; ++x) EXPECT_EQ(grid.At(x, 19), 1) << x;
  for (uint32_t x = 0; x < 40; ++x) EXPECT_EQ(grid.At(x, 18), 0);
  AddSegment({1.05f, -5, 0}, {1.05f, 5, 0}, 1, window, 2, &grid);  // clipped
  for (uint32_t y = 0; y < 19; ++y) EXPECT_EQ(grid.At(10, y), 1) << y;
  EXPECT_EQ(grid.At(10, 19), 2);
  AddSegment({1, 1, 0.2f}, {1, 1, 0.8f}, 2.5f, window, 2, &grid);  // along the view: a point
  EXPECT_EQ(grid.At(10, 10) + grid.At(10, 9) + grid.At(9, 10) + grid.At(9, 9), 2 + 2.5f);
}

}  // namespace
}  // namespace lodestar
