// Every BSDF sampler follows its density, and Sample agrees with Evaluate.
#include <gtest/gtest.h>

#include "tests/scene/bsdf_cases.h"
#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

// The last one along a main axis of the anisotropic lobes: elsewhere their ridges run aslant through (z, phi) at such
// angles, too narrow for the quadrature of the expected counts (their density's integral is tested below all the same).
const std::vector<Vec3> kOutgoing = {Direction(0),         Direction(35),  Direction(80, 200),
                                     Direction(88.5, 100), Direction(140), Direction(93, 90)};
const double kLevel = SidakLevel(0.01, 22 * 6);

std::optional<Vec3> SmoothSample(const Bsdf& bsdf, Vec3 wo, Random& random) {
  const float u_lobe = random.Next1D();
  const auto s = bsdf.Sample(wo, u_lobe, random.Next2D());
  if (!s || s->delta) return std::nullopt;
  return s->wi;
}

TEST(BsdfSampling, ChiSquareOfEveryKind) {
  uint64_t seed = 100;
  for (const BsdfCase& c : BsdfCases()) {
    if (!c.bsdf.HasSmoothLobes()) continue;
    for (const Vec3 wo : kOutgoing) {
      const TestResult r = ChiSquareOnSphere([&](Random& random) { return SmoothSample(c.bsdf, wo, random); },
                                             [&](Vec3 wi) { return c.bsdf.Evaluate(wo, wi).pdf; },
                                             {.level = kLevel, .seed = ++seed, .samples = 100000, .bins = 128});
      EXPECT_TRUE(r.accepted) << c.name << ", wo = " << wo.x << ' ' << wo.y << ' ' << wo.z << ": " << r.message;
    }
  }
}

TEST(BsdfSampling, ChiSquareRejectsAWrongPdfOfEveryKind) {
  uint64_t seed = 500;
  for (const BsdfCase& c : BsdfCases()) {
    if (!c.bsdf.HasSmoothLobes()) continue;
    const Vec3 wo = Direction(50);
    const TestResult r =
        ChiSquareOnSphere([&](Random& random) { return SmoothSample(c.bsdf, wo, random); },
                          [&](Vec3 wi) { return 0.95 * c.bsdf.Evaluate(wo, wi).pdf * (1 + 0.1 * wi.x); },
                          {.level = kLevel, .seed = ++seed, .samples = 100000, .bins = 128});
    EXPECT_FALSE(r.accepted) << c.name << ": " << r.message;
  }
}

// The density integrates to 1 - P(delta) - P(failed sample).
TEST(BsdfSampling, DensityIntegratesToTheChanceOfASmoothSample) {
  for (const BsdfCase& c : BsdfCases()) {
    if (!c.bsdf.HasSmoothLobes()) continue;
    for (const Vec3 wo : {Direction(20), Direction(70, 200), Direction(130), Direction(93, 50)}) {
      Random random(7);
      Moments smooth, delta;
      for (int i = 0; i < 20000; ++i) {
        const float u_lobe = random.Next1D();
        const auto s = c.bsdf.Sample(wo, u_lobe, random.Next2D());
        smooth.Add(s && !s->delta);
        delta.Add(s && s->delta);
      }
      const double integral =
          IntegrateSphere([&](Vec3 wi) { return c.bsdf.Evaluate(wo, wi).pdf; }, Vec3{-wo.x, -wo.y, wo.z}).Total();
      EXPECT_TRUE(TTest(smooth, integral, kLevel, 1e-3).accepted)
          << c.name << TTest(smooth, integral, kLevel, 1e-3).message;
      EXPECT_TRUE(TTest(delta, c.bsdf.DeltaProbability(wo), kLevel, 1e-6).accepted) << c.name;
      EXPECT_LE(integral + c.bsdf.DeltaProbability(wo), 1 + 1e-3) << c.name;
    }
  }
}

TEST(BsdfSampling, SampleAgreesWithEvaluate) {
  for (const BsdfCase& c : BsdfCases()) {
    Random random(11);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 wo = SquareToSphere(random.Next2D());
      const float u_lobe = random.Next1D();
      const auto s = c.bsdf.Sample(wo, u_lobe, random.Next2D());
      if (!s) continue;
      ASSERT_NEAR(LengthSquared(s->wi), 1, 2e-5) << c.name;
      ASSERT_EQ(s->transmission, s->wi.z * wo.z < 0) << c.name;
      ASSERT_GT(s->pdf, 0) << c.name;
      const BsdfValue v = c.bsdf.Evaluate(wo, s->wi);
      if (s->delta) {
        ASSERT_LE(s->pdf, 1) << c.name;
        continue;
      }
      // The half vector is rebuilt from rounded directions: a narrow lobe's density is that much less exact, more so at
      // grazing angles.
      if (std::fabs(wo.z) < 0.02f || std::fabs(s->wi.z) < 0.02f) continue;
      ASSERT_EQ(c.bsdf.EtaAcross(wo, s->wi), s->eta) << c.name;
      ASSERT_NEAR(v.pdf, s->pdf, 5e-3f * s->pdf + 1e-6f) << c.name << " wo.z " << wo.z << " wi.z " << s->wi.z;
      for (int k = 0; k < 3; ++k) {
        ASSERT_NEAR(v.f_cos[k], s->weight[k] * s->pdf, 5e-3f * v.f_cos[k] + 1e-6f) << c.name;
      }
    }
  }
}

TEST(BsdfSampling, DeltaKindsHaveNoSmoothLobes) {
  for (const BsdfCase& c : BsdfCases()) {
    Random random(13);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 wo = SquareToSphere(random.Next2D());
      if (!c.bsdf.HasSmoothLobes()) {
        const BsdfValue v = c.bsdf.Evaluate(wo, SquareToSphere(random.Next2D()));
        EXPECT_TRUE(IsBlack(v.f_cos) && v.pdf == 0) << c.name;
        EXPECT_EQ(c.bsdf.DeltaProbability(wo), c.bsdf.kind() == Bsdf::Kind::kNone ? 0 : 1) << c.name;
      }
    }
  }
}

TEST(BsdfSampling, RelativeIndexFollowsThePath) {
  for (const float alpha : {0.0f, 0.2f}) {
    const Bsdf glass = Bsdf::Dielectric(1.5f, {alpha, alpha});
    for (const Vec3 wo : {Direction(30), Direction(160)}) {
      const auto s = glass.Sample(wo, 0.999f, {0.3f, 0.2f});
      ASSERT_TRUE(s && s->transmission);
      EXPECT_FLOAT_EQ(s->eta, wo.z > 0 ? 1.5f : 1 / 1.5f);
      const auto r = glass.Sample(wo, 0, {0.3f, 0.2f});
      ASSERT_TRUE(r && !r->transmission);
      EXPECT_EQ(r->eta, 1);
    }
  }
}

}  // namespace
}  // namespace lodestar::test
