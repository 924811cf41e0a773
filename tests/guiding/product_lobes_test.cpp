#include "core/guiding/product_lobes.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace lodestar {
namespace {

using enum ProductLobe::Kind;

std::vector<Frame> Frames() {
  return {Frame{}, Frame::FromNormal(Normalize(Vec3{0.3f, -0.8f, 0.5f})), Frame::FromNormal({0, 0, -1})};
}

// That many degrees from the normal, or from its opposite.
Vec3 At(const Frame& frame, float degrees, bool behind) {
  const auto [sin, cos] = SinCos(Radians(degrees));
  return frame.ToWorld({sin, 0, behind ? -cos : cos});
}

// The document's fall-back (Diolatzis et al. 2020, section 3.2.3): a tenth of a degree to either side.
TEST(ProductLobes, GlossCountsAsDiffuseBeyond85Degrees) {
  const std::vector<ProductLobe> lobes = {
      {kGgxReflection, 0.05f, 0.5f}, {kGgxReflection, 0.4f, 0.25f}, {kDiffuseTransmission, 1, 0.25f}};
  for (const Frame& frame : Frames()) {
    for (const bool behind : {false, true}) {
      SCOPED_TRACE(behind);
      const ProductLobes within(frame, At(frame, 84.9f, behind), lobes);
      ASSERT_EQ(within.glossy_count(), 2);
      EXPECT_FLOAT_EQ(within.glossy_weight(0), 0.5f * (1 - ProductLobes::kTailShare));
      EXPECT_FLOAT_EQ(within.glossy_weight(1), 0.25f * (1 - ProductLobes::kTailShare));
      EXPECT_FLOAT_EQ(within.diffuse(), 0.75f * ProductLobes::kTailShare);
      EXPECT_FLOAT_EQ(within.transmission(), 0.25f);

      const ProductLobes beyond(frame, At(frame, 85.1f, behind), lobes);
      EXPECT_EQ(beyond.glossy_count(), 0);
      EXPECT_FLOAT_EQ(beyond.diffuse(), 0.75f);
      EXPECT_FLOAT_EQ(beyond.transmission(), 0.25f);
      const Vec3 normal = behind ? -frame.n : frame.n;
      for (const float degrees : {0.0f, 30.0f, 60.0f, 80.0f, 100.0f, 150.0f}) {
        const Vec3 w = At(frame, degrees, false);
        const float cos = Dot(normal, w);
        EXPECT_FLOAT_EQ(beyond.Density(w), (cos > 0 ? 0.75f * cos : -0.25f * cos) * kInvPi) << degrees;
      }
    }
  }
}

TEST(ProductLobes, AreNoneWhereTheWeightCannotBeDividedBy) {
  for (const auto kind : {kDiffuseReflection, kGgxReflection, kDiffuseTransmission}) {
    for (const float weight : {0.0f, 1e-45f, 1e-40f, kInfinity}) {
      const ProductLobe lobe{kind, 0.3f, weight};
      const ProductLobes lobes({}, {0, 0, 1}, {&lobe, 1});
      EXPECT_TRUE(lobes.none()) << weight;
      EXPECT_EQ(lobes.Density({0, 0.6f, 0.8f}), 0) << weight;
    }
    for (const float weight : {1e-37f, 1e37f}) {
      const std::array<ProductLobe, 2> two = {{{kind, 0.3f, weight}, {kDiffuseReflection, 1, weight}}};
      const ProductLobes lobes({}, {0, 0, 1}, two);
      EXPECT_FALSE(lobes.none());
      const float glossy = lobes.glossy_count() == 0 ? 0 : lobes.glossy_weight(0);
      EXPECT_FLOAT_EQ(lobes.diffuse() + lobes.transmission() + glossy, 1) << weight;
    }
  }
}

}  // namespace
}  // namespace lodestar
