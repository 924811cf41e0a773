// What a BSDF tells of its lobes agrees with what its samples do.
#include <gtest/gtest.h>

#include "tests/scene/bsdf_cases.h"
#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

TEST(BsdfLobes, SharesAreThoseOfTheSamples) {
  for (const BsdfCase& c : BsdfCases()) {
    for (const double theta : {5.0, 40.0, 65.0, 150.0}) {
      const Vec3 wo = Direction(theta);
      const BsdfLobes lobes = c.bsdf.Lobes(wo);
      // Luminance that samples carry, lobe by lobe: told apart by alpha and side, which no two lobes here share.
      double carried[2] = {0, 0}, all = 0;
      Random random(5);
      for (int i = 0; i < 40000; ++i) {
        const float u_lobe = random.Next1D();
        const auto s = c.bsdf.Sample(wo, u_lobe, random.Next2D());
        if (!s) continue;
        const double luminance = Luminance(s->weight) * s->eta * s->eta;
        all += luminance;
        if (s->delta) continue;
        for (int k = 0; k < lobes.count; ++k) {
          const BsdfLobe& lobe = lobes.lobes[k];
          const bool ggx = lobe.kind == BsdfLobe::Kind::kGgxReflection;
          const bool transmitted = lobe.kind == BsdfLobe::Kind::kDiffuseTransmission;
          const float alpha = ggx ? std::sqrt(lobe.alpha.x * lobe.alpha.y) : 1;
          if (s->transmission == transmitted && std::fabs(s->alpha - alpha) < 1e-4f) carried[k] += luminance;
        }
      }
      double sum = 0;
      for (int k = 0; k < lobes.count; ++k) {
        EXPECT_GT(lobes.lobes[k].weight, 0) << c.name;
        // Shares by which a mixture's samples are drawn differ from the albedos' by what the density of the other lobe
        // adds; Fresnel at wo stands in for its mean over a wide lobe, worst for rough glass near total reflection.
        const double tolerance = c.bsdf.kind() == Bsdf::Kind::kDielectric ? 0.2 : 0.13;
        EXPECT_NEAR(lobes.lobes[k].weight, carried[k] / all, tolerance) << c.name << " lobe " << k << " at " << theta;
        sum += lobes.lobes[k].weight;
      }
      EXPECT_LE(sum, 1 + 1e-5) << c.name << " at " << theta;
      if (c.bsdf.kind() != Bsdf::Kind::kDielectric && c.bsdf.DeltaProbability(wo) == 0 &&
          c.bsdf.kind() != Bsdf::Kind::kNone) {
        EXPECT_NEAR(sum, 1, 1e-5) << c.name << " at " << theta;
      }
    }
  }
}

TEST(BsdfLobes, NamesWhatAMaterialIsMadeOf) {
  using Kind = BsdfLobe::Kind;
  const Vec3 wo = Direction(30);
  const auto kinds = [&](const Bsdf& bsdf) {
    std::vector<Kind> result;
    for (const BsdfLobe& lobe : bsdf.Lobes(wo)) result.push_back(lobe.kind);
    return result;
  };
  EXPECT_EQ(kinds(Bsdf::Diffuse(Rgb(0.5f))), std::vector{Kind::kDiffuseReflection});
  EXPECT_EQ(kinds(Bsdf::Diffuse(Rgb(0))), std::vector<Kind>{});
  EXPECT_EQ(kinds(Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.1f, 0.1f})),
            (std::vector{Kind::kGgxReflection, Kind::kDiffuseReflection}));
  EXPECT_EQ(kinds(Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0, 0})), std::vector{Kind::kDiffuseReflection});
  EXPECT_EQ(kinds(Bsdf::DiffuseTransmission(Rgb(0.5f), Rgb(0.1f))),
            (std::vector{Kind::kDiffuseReflection, Kind::kDiffuseTransmission}));
  EXPECT_EQ(kinds(Bsdf::Dielectric(1.5f, {0, 0})), std::vector<Kind>{});
  const BsdfLobes metal = Bsdf::Conductor(kGoldEta, kGoldK, {0.2f, 0.5f}).Lobes(wo);
  ASSERT_EQ(metal.count, 1);
  EXPECT_EQ(metal.lobes[0].alpha, (Vec2{0.2f, 0.5f}));
  EXPECT_FLOAT_EQ(metal.lobes[0].weight, 1);
}

TEST(BsdfLobes, ASampleKnowsItsLobesRoughness) {
  const Vec3 wo = Direction(40);
  EXPECT_EQ(Bsdf::Diffuse(Rgb(0.5f)).Sample(wo, 0.5f, {0.3f, 0.6f})->alpha, 1);
  EXPECT_EQ(Bsdf::Dielectric(1.5f, {0, 0}).Sample(wo, 0.9f, {0.3f, 0.6f})->alpha, 0);
  EXPECT_EQ(Bsdf::ThinDielectric(1.5f).Sample(wo, 0.9f, {0.3f, 0.6f})->alpha, 0);
  EXPECT_EQ(Bsdf::Dielectric(1.5f, {0.2f, 0.2f}).Sample(wo, 0.9f, {0.3f, 0.6f})->alpha, 0.2f);
  EXPECT_EQ(Bsdf::Conductor(kGoldEta, kGoldK, {0.3f, 0.3f}).Sample(wo, 0, {0.3f, 0.6f})->alpha, 0.3f);
  const Bsdf coated = Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.1f, 0.1f});
  EXPECT_EQ(coated.Sample(wo, 0, {0.3f, 0.6f})->alpha, 0.1f);
  EXPECT_EQ(coated.Sample(wo, 0.99f, {0.3f, 0.6f})->alpha, 1);
}

// Seen from the lobes' samples: those of one lobe alone are told their own roughness, whoever drew them.
TEST(BsdfLobes, ADirectionIsOfTheLobeThatGivesItTheGreatestDensity) {
  for (const double theta : {20.0, 50.0, 130.0}) {
    const Vec3 wo = Direction(theta);
    Random random(8);
    for (const Bsdf& bsdf : {Bsdf::Conductor(kGoldEta, kGoldK, {0.2f, 0.5f}), Bsdf::Dielectric(1.5f, {0.2f, 0.2f}),
                             Bsdf::Diffuse(Rgb(0.5f)), Bsdf::DiffuseTransmission(Rgb(0.5f), Rgb(0.3f))}) {
      for (int i = 0; i < 100; ++i) {
        const float u_lobe = random.Next1D();
        const auto sample = bsdf.Sample(wo, u_lobe, random.Next2D());
        if (sample) EXPECT_EQ(bsdf.AlphaAt(wo, sample->wi), sample->alpha);
      }
    }
    // Of two lobes each has its own place.
    const float side = wo.z > 0 ? 1.0f : -1.0f;
    const Vec3 mirrored{-wo.x, -wo.y, wo.z}, beside = Vec3{-wo.y, wo.x, 0} + Vec3{0, 0, 0.3f * side};
    const Bsdf polished = Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.1f, 0.1f});
    EXPECT_EQ(polished.AlphaAt(wo, mirrored), 0.1f);
    EXPECT_EQ(polished.AlphaAt(wo, Normalize(beside)), 1);
    EXPECT_EQ(polished.AlphaAt(wo, -mirrored), 1);                                     // none reaches there
    EXPECT_EQ(Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0, 0}).AlphaAt(wo, mirrored), 1);  // the delta has no density
    const Bsdf brushed = Bsdf::CoatedConductor(1.5f, {0.5f, 0.5f}, kGoldEta, kGoldK, {0, 0});
    EXPECT_EQ(brushed.AlphaAt(wo, mirrored), brushed.Lobes(wo).lobes[1].alpha.x);
  }
}

}  // namespace
}  // namespace lodestar::test
