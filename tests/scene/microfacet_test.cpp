// GGX, its sampler, and the Fresnel equations.
#include "core/scene/microfacet.h"

#include <gtest/gtest.h>

#include <complex>

#include "core/math/warp.h"
#include "core/scene/fresnel.h"
#include "tests/scene/bsdf_cases.h"
#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

const std::vector<Vec2> kAlphas = {{0.05f, 0.05f}, {0.3f, 0.3f}, {0.2f, 0.6f}, {1, 1}};
const double kLevel = SidakLevel(0.01, 4 * 4);

TEST(Ggx, ProjectedAreaOfTheNormalsIsOne) {
  for (const Vec2 alpha : kAlphas) {
    const Ggx ggx{alpha};
    const double area =
        IntegrateSphere([&](Vec3 m) { return m.z > 0 ? ggx.Density(m) * m.z : 0.0f; }, Vec3{0, 0, 1}).upper;
    EXPECT_NEAR(area, 1, 2e-4) << alpha.x << ' ' << alpha.y;
  }
}

TEST(Ggx, DensityIgnoresTheLengthOfTheNormal) {
  const Vec3 m = Direction(25, 70);
  for (const Vec2 alpha : kAlphas) EXPECT_NEAR(Ggx{alpha}.Density(m * 1.7f) / Ggx{alpha}.Density(m), 1, 1e-5);
}

// What is seen from w of all normals is the projected area of the macrosurface: int G1 <w.m> D dm = w.z (Heitz 2014,
// eq. 14).
TEST(Ggx, MaskingMakesVisibleAreaConsistent) {
  for (const Vec2 alpha : kAlphas) {
    const Ggx ggx{alpha};
    for (const double theta : {0.0, 40.0, 75.0}) {
      const Vec3 w = Direction(theta);
      const double g1 = 2 * w.z / (ggx.Stretch(w) + w.z);
      const double area =
          IntegrateSphere([&](Vec3 m) { return m.z > 0 ? g1 * std::max(Dot(w, m), 0.0f) * ggx.Density(m) : 0.0; },
                          Vec3{0, 0, 1})
              .upper;
      EXPECT_NEAR(area, w.z, 5e-4) << alpha.x << ' ' << alpha.y << " at " << theta;
    }
  }
}

TEST(Ggx, VisibleNormalsFollowTheirDensity) {
  for (const Vec2 alpha : kAlphas) {
    const Ggx ggx{alpha};
    for (const double theta : {0.0, 40.0, 75.0, 88.0}) {
      const Vec3 wo = Direction(theta);
      const auto density = [&](Vec3 m) {
        return m.z > 0 ? 2 * std::max(Dot(wo, m), 0.0f) * ggx.Density(m) / (ggx.Stretch(wo) + wo.z) : 0.0f;
      };
      const auto sampler = [&](Random& random) { return std::optional(ggx.SampleVisible(wo, random.Next2D())); };
      const TestResult r =
          ChiSquareOnSphere(sampler, density, {.level = kLevel, .seed = 21, .samples = 100000, .bins = 128});
      EXPECT_TRUE(r.accepted) << alpha.x << ' ' << alpha.y << " at " << theta << ": " << r.message;
      const Ggx wrong{{alpha.x * 1.1f, alpha.y}};
      EXPECT_FALSE(ChiSquareOnSphere(sampler,
                                     [&](Vec3 m) {
                                       return m.z > 0 ? 2 * std::max(Dot(wo, m), 0.0f) * wrong.Density(m) /
                                                            (wrong.Stretch(wo) + wo.z)
                                                      : 0.0f;
                                     },
                                     {.level = kLevel, .seed = 21, .samples = 100000, .bins = 128})
                       .accepted);
    }
  }
}

// Eto and Tokuyoshi 2023: the bounded normals have all that reflect wo above the surface, and fewer others.
TEST(Ggx, BoundedReflectionsFollowTheirDensityAndMissLess) {
  for (const Vec2 alpha : kAlphas) {
    const Ggx ggx{alpha};
    for (const double theta : {0.0, 40.0, 75.0, 88.0}) {
      const Vec3 wo = Direction(theta);
      const auto reflected = [&](Random& random, float bound) -> std::optional<Vec3> {
        const Vec3 m = ggx.SampleVisible(wo, random.Next2D(), bound), wi = m * (2 * Dot(wo, m)) - wo;
        return wi.z > 0 ? std::optional(wi) : std::nullopt;
      };
      const float bound = ggx.ReflectionBound(wo);
      ASSERT_GE(bound, 0);
      ASSERT_LE(bound, 1);
      const auto test = [&](float sampled, float evaluated) {
        return ChiSquareOnSphere(
            [&](Random& random) { return reflected(random, sampled); },
            [&](Vec3 wi) { return wi.z > 0 ? EvaluateMirrored(ggx, wo, wi, evaluated).pdf : 0.0f; },
            {.level = kLevel, .seed = 22, .samples = 100000, .bins = 128});
      };
      const TestResult r = test(bound, bound);
      EXPECT_TRUE(r.accepted) << alpha.x << ' ' << alpha.y << " at " << theta << ": " << r.message;
      Random random(23), same(23);
      int missed = 0, missed_unbounded = 0;
      for (int i = 0; i < 20000; ++i) {
        missed += !reflected(random, bound);
        missed_unbounded += !reflected(same, 1);
      }
      EXPECT_LE(missed, missed_unbounded);
      if (std::min(alpha.x, alpha.y) >= 0.5f && theta < 60) {
        EXPECT_LT(missed, 0.8 * missed_unbounded);
        EXPECT_FALSE(test(bound, 1).accepted);  // the other density is told from this one
      }
    }
  }
}

// What would end below the surface is folded up: nothing is lost, and the density is that of both.
TEST(Ggx, FoldedReflectionsFollowTheirDensityAndMissNothing) {
  for (const Vec2 alpha : kAlphas) {
    const Ggx ggx{alpha};
    for (const double theta : {0.0, 40.0, 75.0, 88.0}) {
      const Vec3 wo = Direction(theta);
      const auto test = [&](auto evaluate) {
        return ChiSquareOnSphere(
            [&](Random& random) { return std::optional(ggx.SampleReflection(wo, random.Next2D())); },
            [&](Vec3 wi) { return wi.z > 0 ? evaluate(wi).pdf : 0.0f; },
            {.level = kLevel, .seed = 24, .samples = 100000, .bins = 128});
      };
      const TestResult r = test([&](Vec3 wi) { return EvaluateReflection(ggx, wo, wi); });
      EXPECT_TRUE(r.accepted) << alpha.x << ' ' << alpha.y << " at " << theta << ": " << r.message;
      const auto pdf = [&](Vec3 wi) { return wi.z > 0 ? EvaluateReflection(ggx, wo, wi).pdf : 0.0f; };
      EXPECT_NEAR(IntegrateSphere(pdf, Vec3{-wo.x, -wo.y, wo.z}).Total(), 1, 2e-3)
          << alpha.x << ' ' << alpha.y << " at " << theta;
      if (alpha.x >= 0.2f && alpha.x < 1 && theta == 75) {  // without what was folded it is told apart
        EXPECT_FALSE(test([&](Vec3 wi) { return EvaluateMirrored(ggx, wo, wi, ggx.ReflectionBound(wo)); }).accepted)
            << alpha.x << ' ' << alpha.y << " at " << theta;
      }
    }
  }
}

TEST(Ggx, SampledNormalsAreUnitAndUpright) {
  for (const float alpha : {1e-4f, 1e-3f, 0.1f, 1.0f}) {
    for (const float z : {1.0f, 0.5f, 1e-3f, 1e-7f}) {
      for (const float u : {0.0f, 0.3f, 0.5f, kOneMinusEpsilon}) {
        for (const float v : {0.0f, 0.3f, 0.999f, kOneMinusEpsilon}) {
          const Vec3 m = Ggx{{alpha, alpha}}.SampleVisible({std::sqrt(1 - z * z), 0, z}, {u, v});
          ASSERT_TRUE(IsFinite(m));
          ASSERT_NEAR(LengthSquared(m), 1, 1e-5);
          ASSERT_GE(m.z, 0);
        }
      }
    }
  }
}

// ---- Fresnel --------------------------------------------------------------------------------------------------------

double ReferenceFresnel(double cos_i, std::complex<double> eta) {
  const std::complex<double> cos_t = std::sqrt(1.0 - (1 - cos_i * cos_i) / (eta * eta));
  const auto parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t),
             perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5 * (std::norm(parallel) + std::norm(perpendicular));
}

TEST(Fresnel, DielectricMatchesTheComplexForm) {
  double worst = 0;
  for (const float eta : {0.4f, 1 / 1.5f, 1.0001f, 1.33f, 1.5f, 3.0f}) {
    for (int i = 1; i <= 1000; ++i) {
      const float cos = static_cast<float>(i) / 1000;
      // At the critical angle the slope is infinite.
      if (std::fabs(1 - (1 - cos * cos) / (eta * eta)) < 1e-3f) continue;
      worst = std::max(worst, std::fabs(FresnelDielectric(cos, eta).reflectance - ReferenceFresnel(cos, eta)));
    }
  }
  EXPECT_LT(worst, 2e-5);
  EXPECT_FLOAT_EQ(FresnelDielectric(1, 1.5f).reflectance, 0.04f);
  EXPECT_EQ(FresnelDielectric(0.5f, 1).reflectance, 0);
  EXPECT_EQ(FresnelDielectric(0.1f, 1 / 1.5f).reflectance, 1);  // total
  EXPECT_EQ(FresnelDielectric(0, 1.5f).reflectance, 1);
}

TEST(Fresnel, ConductorMatchesTheComplexForm) {
  double worst = 0;
  for (const float eta : {0.1f, 0.5f, 1.0f, 2.0f, 5.0f}) {
    for (const float k : {1e-3f, 0.5f, 2.0f, 6.0f}) {
      for (int i = 1; i <= 1000; ++i) {
        const float cos = static_cast<float>(i) / 1000;
        if (k < 0.1f && eta < 1)
          continue;  // nearly a dielectric beyond its critical angle: the slope is nearly infinite
        const Rgb f = FresnelConductor(cos, Rgb(eta), Rgb(k));
        EXPECT_EQ(f.r, f.b);
        worst = std::max(worst, std::fabs(f.g - ReferenceFresnel(cos, {eta, k})));
      }
    }
  }
  EXPECT_LT(worst, 1e-4);
}

TEST(Fresnel, RefractionFollowsSnell) {
  Random random(41);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 m = SquareToSphere(random.Next2D());
    const Vec3 w = FaceForward(SquareToSphere(random.Next2D()), m);
    const float eta = 0.5f + 2 * random.Next1D(), cos = Dot(w, m);
    const DielectricFresnel f = FresnelDielectric(cos, eta);
    if (f.reflectance == 1 || f.cos_t < 0.01f) continue;
    const Vec3 t = Refract(w, m, cos, f.cos_t, eta);
    ASSERT_NEAR(LengthSquared(t), 1, 1e-5);
    ASSERT_NEAR(Dot(t, m), -f.cos_t, 1e-5);
    ASSERT_NEAR(Length(Cross(t, m)) * eta, Length(Cross(w, m)), 1e-4);
  }
}

}  // namespace
}  // namespace lodestar::test
