#include "core/guiding/focal_projection.h"

#include <gtest/gtest.h>

#include "tests/guiding/focal_testing.h"

namespace lodestar {
namespace {

using Kind = FocalProjection::Kind;

TEST(FocalProjection, AUniformFieldIsEvenlyOne) {
  const auto field = FocalField::Initial({{0, 0, 0}, {4, 2, 1}}, {});
  for (const Kind kind : {Kind::kMaximum, Kind::kAverage}) {
    for (int axis = 0; axis < 3; ++axis) {
      const FocalProjection projection = ProjectAlong(*field, kind, axis, 20);
      ASSERT_EQ(projection.values.size(), size_t{20} * projection.height);
      for (const float value : projection.values) ASSERT_NEAR(value, 1, 1e-4);
    }
    EXPECT_EQ(ProjectAlong(*field, kind, 2, 20).height, 10u);
  }
}

TEST(FocalProjection, TheLightIsTheBrightestPixel) {
  focal_testing::Training training;
  const auto field = focal_testing::Train(training, 12);
  for (const Kind kind : {Kind::kMaximum, Kind::kAverage}) {
    const FocalProjection projection = ProjectAlong(*field, kind, 2, 64);
    const size_t brightest = static_cast<size_t>(std::max_element(projection.values.begin(), projection.values.end()) -
                                                 projection.values.begin());
    EXPECT_NEAR((static_cast<float>(brightest % 64) + 0.5f) / 64, training.light.x, 0.05f);
    EXPECT_NEAR(1 - (static_cast<float>(brightest / 64) + 0.5f) / 64, training.light.y, 0.05f);
    EXPECT_GT(projection.values[brightest], 3);
  }
}

// The mean over all pixels of the average along them is the mean density, whatever the field.
TEST(FocalProjection, AveragesKeepTheMass) {
  const auto field = focal_testing::RandomField({{0, 0, 0}, {1, 1, 1}}, 4, 3);
  const FocalProjection projection = ProjectAlong(*field, Kind::kAverage, 0, 64);
  double mean = 0;
  for (const float value : projection.values) mean += value / static_cast<double>(projection.values.size());
  EXPECT_NEAR(mean, 1, 1e-4);
}

TEST(FocalProjection, RaysThatMissTheBoxAreBlack) {
  const auto field = FocalField::Initial({{0, 0, 0}, {1, 1, 1}}, {});
  const FocalProjection projection = Project(*field, Kind::kMaximum, 2, 1, [](uint32_t x, uint32_t) {
    return FocalPixelRay{{-1, 0.5f, 0.5f}, {x == 0 ? 1.0f : -1.0f, 0, 0}};
  });
  EXPECT_NEAR(projection.values[0], 1, 1e-5);
  EXPECT_EQ(projection.values[1], 0);
}

}  // namespace
}  // namespace lodestar
