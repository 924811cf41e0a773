#include "core/guiding/focal_projection.h"

#include <gtest/gtest.h>

#include "tests/guiding/focal_testing.h"

namespace lodestar {
namespace {

using Kind = FocalProjection;

TEST(FocalProjection, AUniformFieldIsEvenlyOne) {
  const auto field = FocalField::Initial({{0, 0, 0}, {4, 2, 1}}, {});
  for (const Kind kind : {Kind::kMaximum, Kind::kAverage}) {
    for (int axis = 0; axis < 3; ++axis) {
      const FloatGrid projection = ProjectAlong(*field, 0, kind, axis, 20);
      ASSERT_EQ(std::max(projection.width, projection.height), 20u);
      for (const float value : projection.values) ASSERT_NEAR(value, 1, 1e-4);
    }
    EXPECT_EQ(ProjectAlong(*field, 0, kind, 2, 20).height, 10u);
  }
}

TEST(FocalProjection, TheLightIsTheBrightestPixel) {
  focal_testing::Training training;
  const auto field = focal_testing::Train(training, 12);
  for (const Kind kind : {Kind::kMaximum, Kind::kAverage}) {
    const FloatGrid projection = ProjectAlong(*field, 0, kind, 2, 64);
    const size_t brightest = static_cast<size_t>(std::max_element(projection.values.begin(), projection.values.end()) -
                                                 projection.values.begin());
    EXPECT_NEAR((static_cast<float>(brightest % 64) + 0.5f) / 64, training.light.x, 0.05f);
    EXPECT_NEAR(1 - (static_cast<float>(brightest / 64) + 0.5f) / 64, training.light.y, 0.05f);
    EXPECT_GT(projection.values[brightest], 3);
  }
}

TEST(FocalProjection, AveragesKeepTheMassAndVoxelsWithinPixelsAreNotMissed) {
  const auto field = focal_testing::RandomField({{-1, 0, 2}, {1, 4, 3}}, 7, 5, 4, true);
  for (size_t octree = 0; octree < 2; ++octree) {
    for (int axis = 0; axis < 3; ++axis) {
      // 150 pixels: voxels end within pixels.
      const FloatGrid mean = ProjectAlong(*field, octree, Kind::kAverage, axis, 150);
      const FloatGrid greatest = ProjectAlong(*field, octree, Kind::kMaximum, axis, 150);
      EXPECT_EQ(std::max(mean.width, mean.height), 150u);
      double sum = 0;
      for (size_t i = 0; i < mean.values.size(); ++i) {
        sum += mean.values[i];
        EXPECT_LE(mean.values[i], greatest.values[i] * 1.0001f);
      }
      EXPECT_NEAR(sum / static_cast<double>(mean.values.size()), field->octrees()[octree].mass() / field->mass(), 1e-3);
    }
  }
}

TEST(FocalProjection, RaysAcrossTheBoxSeeWhatTheProjectionShows) {
  const auto field = focal_testing::RandomField({{-1, 0, 2}, {1, 4, 3}}, 5, 9);
  for (const Kind kind : {Kind::kMaximum, Kind::kAverage}) {
    const FloatGrid along = ProjectAlong(*field, 0, kind, 0, 300);
    const FloatGrid rays = Project(*field, 0, kind, along.width, along.height, [&](uint32_t x, uint32_t y) {
      const Vec2 at{(static_cast<float>(x) + 0.5f) / static_cast<float>(along.width),
                    1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(along.height)};
      const Vec3 corner = field->corner(), sides = field->sides();
      return FocalPixelRay{{corner.x - 1, corner.y + at.x * sides.y, corner.z + at.y * sides.z}, {1, 0, 0}};
    });
    size_t compared = 0;
    for (uint32_t y = 1; y + 1 < along.height; ++y) {
      for (uint32_t x = 1; x + 1 < along.width; ++x) {
        // A pixel on a voxel's border has some of both sides.
        const float value = along.At(x, y);
        if (along.At(x - 1, y) != value || along.At(x + 1, y) != value || along.At(x, y - 1) != value ||
            along.At(x, y + 1) != value)
          continue;
        ++compared;
        ASSERT_NEAR(rays.At(x, y), value, 1e-3f * value + 1e-6f) << x << "," << y;
      }
    }
    EXPECT_GT(compared, along.values.size() / 8);
  }
}

// A voxel of 2^-16 of the side is smaller than any pixel.
TEST(FocalProjection, NoFocusIsTooSmallToShow) {
  FocalParts parts = PartsOf(*FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {}));
  FocalParts::Octree octree;
  for (int level = 1; level <= FocalOctree::kMaxDepth; ++level) {
    const bool last = level == FocalOctree::kMaxDepth;
    octree.inner.push_back(last ? 0 : 1 << (level % 8));
    for (int c = 0; c < (last ? 8 : 7); ++c) octree.leaf_masses.push_back(last && c == 5 ? 1.0f : 1e-6f);
  }
  parts.octrees = {octree};
  parts.weight = 1;
  const FocalField field(std::move(parts));
  const FloatGrid grid = ProjectAlong(field, 0, Kind::kMaximum, 1, 50);
  EXPECT_GT(*std::max_element(grid.values.begin(), grid.values.end()), 0x1p40f);
}

TEST(FocalProjection, RaysThatMissTheBoxAreBlack) {
  const auto field = FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {});
  const FloatGrid projection = Project(*field, 0, Kind::kMaximum, 2, 1, [](uint32_t x, uint32_t) {
    return FocalPixelRay{{-1, 0.5f, 0.5f}, {x == 0 ? 1.0f : -1.0f, 0, 0}};
  });
  EXPECT_NEAR(projection.values[0], 1, 1e-5);
  EXPECT_EQ(projection.values[1], 0);
}

}  // namespace
}  // namespace lodestar
