#include "core/guiding/ltc.h"

#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "core/scene/microfacet.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

Vec3 Along(float cos, float phi) {
  const auto [s, c] = SinCos(phi);
  const float r = SafeSqrt(1 - cos * cos);
  return {r * c, r * s, cos};
}

TEST(Ltc, TheIdentityIsTheCosine) {
  const Ltc ltc(LtcShape{}, Frame{});
  for (const float cos : {0.1f, 0.5f, 1.0f}) EXPECT_NEAR(ltc.Density(Along(cos, 1)), cos * kInvPi, 1e-6);
  EXPECT_EQ(ltc.Density({0, 0.6f, -0.8f}), 0);
  EXPECT_NEAR(ltc.ShareAbove({0, 0, 1}), 1, 1e-6);
  EXPECT_NEAR(ltc.ShareAbove({1, 0, 0}), 0.5, 1e-6);
}

TEST(Ltc, IntegratesToOneAndKnowsItsShareAboveAnyPlane) {
  const Frame frame = Frame::FromNormal(Normalize(Vec3{0.2f, 0.5f, 0.7f}));
  for (const float alpha : {0.03f, 0.2f, 0.6f, 1.0f}) {
    for (const float cos : {1.0f, 0.6f, 0.1f}) {
      SCOPED_TRACE(std::to_string(alpha) + " " + std::to_string(cos));
      const LtcShape shape = LtcTable::GgxReflection(alpha, cos);
      const Ltc ltc(shape, frame), flat(shape, Frame{});
      const Vec3 peak = frame.ToWorld({shape.peak_sin, 0, SafeSqrt(1 - Sqr(shape.peak_sin))});
      EXPECT_NEAR(test::IntegrateSphere([&](Vec3 w) { return ltc.Density(w); }, peak).Total(), 1, 2e-3);
      const Vec3 flat_peak{shape.peak_sin, 0, SafeSqrt(1 - Sqr(shape.peak_sin))};
      EXPECT_NEAR(test::IntegrateSphere([&](Vec3 w) { return flat.Density(w); }, flat_peak).upper,
                  flat.ShareAbove({0, 0, 1}), 2e-3);
    }
  }
}

// Narrower, wider and more skewed than the table's, down to M that are all but singular. Their densities cannot be
// integrated over directions in floats; that the rows of M^-1 have the determinant by which they are normalised can be
// told.
TEST(Ltc, ExtremesAreFiniteAndNormalised) {
  for (const LtcShape& shape :
       {LtcShape{1e-6f, 1, 1e3f, 0.9999f}, LtcShape{1e-6f, 1, -1e3f, 0.9999f}, LtcShape{1, 1e-6f, 0, 0.9999f},
        LtcShape{1e-6f, 1e-6f, 0, 0}, LtcShape{1e3f, 1e3f, 0, 0}, LtcShape{1e-3f, 1e3f, 10, 1}}) {
    for (const Frame& frame : {Frame{}, Frame::FromNormal(Normalize(Vec3{0.2f, 0.5f, -0.7f}))}) {
      SCOPED_TRACE(std::to_string(shape.x) + " " + std::to_string(shape.y) + " " + std::to_string(shape.skew));
      const Ltc ltc(shape, frame);
      const Vec3 x = ltc.x(), y = ltc.y(), z = ltc.z();
      EXPECT_TRUE(std::isfinite(ltc.width()) && ltc.width() > 0) << ltc.width();
      EXPECT_TRUE(std::isfinite(ltc.determinant()) && ltc.determinant() > 0) << ltc.determinant();
      const auto cofactor = [&](float Vec3::*a, float Vec3::*b) {
        return static_cast<double>(y.*a) * z.*b - static_cast<double>(y.*b) * z.*a;
      };
      const double determinant =
          x.x * cofactor(&Vec3::y, &Vec3::z) + x.y * cofactor(&Vec3::z, &Vec3::x) + x.z * cofactor(&Vec3::x, &Vec3::y);
      // The row of the skew is rounded at its own length.
      const double skew = shape.skew, rounding = 64 * 0x1p-24 * std::sqrt(1 + skew * skew);
      EXPECT_NEAR(determinant / ltc.determinant(), 1, rounding);

      const Vec3 peak = Normalize(Cross(x, y));
      for (int i = 0; i < 400; ++i) {
        const Vec3 around = Along(2 * static_cast<float>(i) / 399 - 1, 7 * static_cast<float>(i));
        for (const float distance : {0.0f, 1e-6f, 1e-3f, 0.9f, 1e6f}) {
          const Vec3 w = Normalize(peak + around * distance);
          const float density = ltc.Density(w);
          ASSERT_TRUE(std::isfinite(density) && density >= 0) << density;
        }
        const float share = ltc.ShareAbove(around);
        ASSERT_TRUE(share >= -1e-6f && share <= 1 + 1e-6f) << share;
        ASSERT_NEAR(share + ltc.ShareAbove(-around), 1, 1e-6);
      }
    }
  }
}

// Needles and blades, by the cosine that they are made of: M p, times det M^-1, is a sum of the rows' cross products.
TEST(Ltc, NarrowLobesHaveTheCosinesDensityTimesTheirJacobian) {
  for (const LtcShape& shape : {LtcShape{1e-3f, 1e-3f, 0, 0.9f}, LtcShape{1e-3f, 1, 0, 0.9999f},
                                LtcShape{1, 1e-3f, 0, 0.5f}, LtcShape{0.01f, 1, 3, 0.95f}}) {
    const Ltc ltc(shape, Frame::FromNormal(Normalize(Vec3{-0.4f, 0.1f, 0.7f})));
    const Vec3 mx = Cross(ltc.y(), ltc.z()), my = Cross(ltc.z(), ltc.x()), mz = Cross(ltc.x(), ltc.y());
    for (int i = 0; i < 32 * 32; ++i) {
      const Vec3 p = SquareToCosineHemisphere(
          {(static_cast<float>(i % 32) + 0.5f) / 32, (static_cast<float>(i / 32) + 0.5f) / 32});
      const Vec3 v = mx * p.x + my * p.y + mz * p.z;
      const double determinant = ltc.determinant(), length = Length(v);
      const double jacobian = determinant * determinant / (length * length * length);
      // M^-1 stretches the rounding of a direction a thousand times, and the density goes with its fourth power.
      ASSERT_NEAR(ltc.Density(Normalize(v)) * jacobian / (p.z * kInvPi), 1, 0.01)
          << shape.x << " " << shape.y << " " << shape.skew << ", point " << i;
    }
  }
}

// Divergences of the LTC, cut off at the horizon and with its cosine tail, from the lobe it stands for.
struct Fit {
  double divergence = 0, chi_square = 0, total_variation = 0, integral = 0;
};
Fit Compare(float alpha, float cos) {
  const Ggx ggx{{alpha, alpha}};
  const Vec3 wo{-SafeSqrt(1 - cos * cos), 0, cos};
  const Ltc ltc(LtcTable::GgxReflection(alpha, cos), Frame{});
  constexpr int kPhis = 24, kCaps = 48;
  Fit fit;
  double albedo = 0;
  for (const bool counting : {false, true}) {
    for (int n = 0; n < kPhis * kCaps; ++n) {
      const VisibleNormalNode node = VisibleNormalQuadrature(n, kPhis, kCaps);
      const Vec3 m = ggx.SampleVisible(wo, node.u), w = Normalize(m * (2 * Dot(wo, m)) - wo);
      if (!(w.z > 0)) continue;
      const double weight = node.weight * MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(w), w.z);
      if (!counting) {
        albedo += weight;
        continue;
      }
      const double f = EvaluateMirrored(ggx, wo, w).value / albedo, d = 0.98 * ltc.Density(w) + 0.02 * w.z * kInvPi;
      fit.divergence += weight / albedo * std::log(f / d);
      fit.chi_square += weight / albedo * f / d;
      fit.total_variation += weight / albedo * std::max(0.0, 1 - d / f);
    }
  }
  fit.chi_square -= 1;
  fit.integral = 0.98 * ltc.ShareAbove({0, 0, 1}) + 0.02;
  return fit;
}

// Between the table's entries too. bench/ltc_fit.cpp states the error of each entry.
TEST(LtcTable, FitsTheReflectionLobe) {
  double worst_divergence = 0, mean_divergence = 0, mean_chi_square = 0, mean_variation = 0, least_integral = 1;
  int count = 0;
  for (int i = 0; i < 14; ++i) {
    for (int j = 0; j < 14; ++j) {
      const float alpha = 0.02f * std::pow(50.0f, (static_cast<float>(i) + 0.37f) / 14);
      const float cos = 1 - Sqr((static_cast<float>(j) + 0.41f) / 14) * (1 - LtcTable::kMinCos);
      const Fit fit = Compare(alpha, cos);
      worst_divergence = std::max(worst_divergence, fit.divergence);
      mean_divergence += fit.divergence, mean_chi_square += fit.chi_square, mean_variation += fit.total_variation;
      least_integral = std::min(least_integral, fit.integral);
      ++count;
    }
  }
  EXPECT_LT(mean_divergence / count, 0.02);
  EXPECT_LT(worst_divergence, 0.25);
  EXPECT_LT(mean_chi_square / count, 0.06);
  EXPECT_LT(mean_variation / count, 0.05);
  EXPECT_GT(least_integral, 0.93);
}

TEST(LtcTable, IsFiniteEverywhere) {
  for (const float alpha : {0.0f, 1e-4f, 0.02f, 0.5f, 1.0f, 2.0f}) {
    for (const float cos : {0.0f, 1e-6f, 0.08f, 0.5f, 0.999999f, 1.0f}) {
      const LtcShape shape = LtcTable::GgxReflection(alpha, cos);
      EXPECT_GT(shape.x, 0);
      EXPECT_GT(shape.y, 0);
      const Ltc ltc(shape, Frame{});
      EXPECT_TRUE(std::isfinite(ltc.width()) && ltc.width() > 1e-3f && std::isfinite(ltc.determinant()));
      for (int i = 0; i < 50; ++i) {
        const float density = ltc.Density(Along(2 * static_cast<float>(i) / 49 - 1, static_cast<float>(i)));
        EXPECT_TRUE(std::isfinite(density) && density >= 0);
      }
    }
  }
}

// The peak of narrow lobes lies in the mirror direction, between entries too.
TEST(LtcTable, NarrowLobesPointAtTheMirrorDirection) {
  for (int j = 0; j < 200; ++j) {
    const float cos = 0.1f + 0.9f * static_cast<float>(j) / 199;
    EXPECT_NEAR(LtcTable::GgxReflection(0.02f, cos).peak_sin, SafeSqrt(1 - cos * cos), 2e-3);
  }
}

}  // namespace
}  // namespace lodestar
