// The coated diffuse base against what its model promises, the coated conductor against a brute-force random walk
// between the interface and the base, and what the approximations cost.
//
// The diffuse base has no such comparison: its coupling is no layer of a physical index (docs/decisions/0005-coats.md),
// so that the walk, 1 / eta^2 and inter-reflections included, is another model by design.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "tests/scene/bsdf_cases.h"
#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

// The directions that leave, by moments: albedo, mean cosine, mean square cosine, and the part on wo's side.
constexpr int kMoments = 4;
using Outgoing = std::array<Moments, kMoments>;

void AddOutgoing(Outgoing& out, double weight, Vec3 wi) {
  const double values[kMoments] = {weight, weight * wi.z, weight * wi.z * wi.z, wi.x > 0 ? weight : 0};
  for (int i = 0; i < kMoments; ++i) out[i].Add(values[i]);
}

// Light is followed backwards from wo: through the interface, to the base, up again, until it leaves. Exactly the light
// transport between two parallel boundaries; nothing is absorbed between them.
Outgoing RandomWalk(float interface_eta, Vec2 interface_alpha, const Bsdf& base, Vec3 wo, int samples, uint64_t seed) {
  const Bsdf interface = Bsdf::Dielectric(interface_eta, interface_alpha);
  Random random(seed);
  Outgoing out;
  const auto sample = [&](const Bsdf& bsdf, Vec3 w) {
    const float u_lobe = random.Next1D();
    return bsdf.Sample(w, u_lobe, random.Next2D());
  };
  for (int n = 0; n < samples; ++n) {
    double weight = 0;
    Vec3 leaving{0, 0, 1};
    auto s = sample(interface, wo);
    if (s && !s->transmission) {
      weight = s->weight.r;
      leaving = s->wi;
    } else if (s) {
      double beta = s->weight.r;
      Vec3 w = s->wi;  // travels downwards
      for (int depth = 0; depth < 1000; ++depth) {
        // Directions at a boundary point away from it: the light that arrives along w is seen from -w.
        s = sample(depth % 2 == 0 ? base : interface, -w);
        if (!s) break;
        beta *= s->weight.r;
        w = s->wi;
        if (depth % 2 == 1 && s->transmission) {
          weight = beta;
          leaving = w;
          break;
        }
      }
    }
    AddOutgoing(out, weight, leaving);
  }
  return out;
}

Outgoing Analytic(const Bsdf& bsdf, Vec3 wo, int samples, uint64_t seed) {
  Random random(seed);
  Outgoing out;
  for (int n = 0; n < samples; ++n) {
    const float u_lobe = random.Next1D();
    const auto s = bsdf.Sample(wo, u_lobe, random.Next2D());
    AddOutgoing(out, s ? double{s->weight.r} : 0, s ? s->wi : Vec3{0, 0, 1});
  }
  return out;
}

TEST(CoatedDiffuse, TheWhiteFurnaceIsOneAtEveryRoughness) {
  constexpr double kTolerance = 2e-3;  // the tables against the lobe that is sampled
  const double level = SidakLevel(0.01, 10 * 4 * 7);
  double worst = 0;
  uint64_t seed = 1000;
  for (const float alpha : {0.0f, 2e-3f, 6e-3f, 0.02f, 0.05f, 0.1f, 0.13f, 0.4f, 0.7f, 1.0f}) {
    for (const float eta : {1.0f, 1.2f, 1.5f, 2.0f}) {
      const Bsdf white = Bsdf::CoatedDiffuse(Rgb(1), eta, {alpha, alpha});
      for (const double theta : {0.0, 20.0, 40.0, 60.0, 75.0, 85.0, 89.0}) {
        const Outgoing out = Analytic(white, Direction(theta), 20000, ++seed);
        // Between the alphas of the table up to 1 % is lost past 85 degrees; as little as elsewhere is gained.
        const TestResult r = theta > 85 ? TTest(out[0], 0.9955, level, 0.0065) : TTest(out[0], 1, level, kTolerance);
        EXPECT_TRUE(r.accepted) << "alpha " << alpha << " eta " << eta << " theta " << theta << ": " << r.message;
        worst = std::max(worst, std::fabs(out[0].mean() - 1) - 3 * out[0].standard_error());
      }
    }
  }
  std::printf("largest deviation from 1, less three standard errors: %.5f\n", worst);
}

TEST(CoatedDiffuse, TheFurnaceSeesAMissingPercent) {
  for (const float alpha : {0.0f, 0.1f, 1.0f}) {
    const Outgoing out = Analytic(Bsdf::CoatedDiffuse(Rgb(0.985f), 1.5f, {alpha, alpha}), Direction(40), 20000, 3);
    EXPECT_FALSE(TTest(out[0], 1, 1e-4, 2e-3).accepted) << alpha;
  }
}

// What the isotropic coupling costs: the bound is what was measured, rounded up. Nothing gained but by the tables.
TEST(CoatedDiffuse, TheAnisotropicWhiteFurnaceIsJustBelowOne) {
  double lowest = 1, highest = 1;
  for (const Vec2 alpha : {Vec2{0.4f, 0.1f}, {0.2f, 0.1f}, {0.8f, 0.1f}, {0.1f, 0.025f}, {1, 0.25f}}) {
    for (const float eta : {1.5f, 2.0f}) {
      for (const double theta : {0.0, 45.0, 75.0, 85.0, 89.0}) {
        for (const double phi : {0.0, 45.0, 90.0}) {
          const Outgoing out = Analytic(Bsdf::CoatedDiffuse(Rgb(1), eta, alpha), Direction(theta, phi), 20000, 4);
          lowest = std::min(lowest, out[0].mean());
          highest = std::max(highest, out[0].mean() - 4 * out[0].standard_error());
        }
      }
    }
  }
  std::printf("albedo of an anisotropic white coat: %.4f to %.4f\n", lowest, highest);
  EXPECT_GT(lowest, 0.87);
  EXPECT_LE(highest, 1.002);
}

TEST(CoatedDiffuse, TheBaseIsLambertianWhereTheLobeLeavesEnough) {
  for (const float alpha : {0.0f, 0.1f, 0.6f}) {
    const auto value = [&](float reflectance, Vec3 wo, Vec3 wi) {
      return Bsdf::CoatedDiffuse(Rgb(reflectance), 1.5f, {alpha, alpha}).Evaluate(wo, wi).f_cos.r;
    };
    const float most = CoatTable::For(1.5f).LargestTransmittance(CoatTable::RowOf(alpha));
    EXPECT_NEAR(most, 0.965f, 0.012f);
    for (const double theta : {0.0, 50.0, 70.0}) {
      const Vec3 wo = Direction(theta), wi = Direction(60, 250);
      const float black = value(0, wo, wi);
      for (const float reflectance : {0.01f, 0.07f, 0.3f, 0.6f}) {
        // 8e-3: grazing directions, where the base is capped, and what the rest returns for them.
        const float expected = reflectance * most * wi.z * kInvPi;
        EXPECT_NEAR(value(reflectance, wo, wi) - black, expected, 8e-3f * expected + 1e-6f * black)
            << alpha << ' ' << theta << ' ' << reflectance;
      }
    }
  }
}

TEST(CoatedDiffuse, NoReflectanceGainsEnergyAtGrazingAngles) {
  for (const float alpha : {0.0f, 0.05f, 0.3f, 1.0f}) {
    for (const float eta : {1.3f, 1.5f, 2.0f}) {
      for (const float reflectance : {0.5f, 0.8f, 0.95f}) {
        for (const double theta : {60.0, 75.0, 85.0, 89.0}) {
          const Outgoing out =
              Analytic(Bsdf::CoatedDiffuse(Rgb(reflectance), eta, {alpha, alpha}), Direction(theta), 10000, 11);
          EXPECT_LE(out[0].mean() - 4 * out[0].standard_error(), 1 + 2e-3) << alpha << ' ' << eta << ' ' << theta;
          EXPECT_GE(out[0].mean() + 4 * out[0].standard_error(), reflectance * 0.95) << alpha << ' ' << theta;
        }
      }
    }
  }
}

TEST(CoatedDiffuse, TheFlatCoatIsTheCappedCoupledFormWithFresnel) {
  // Fresnel at index 1.5 by Snell's law, in double; its mean from outside is 0.0918 (Egan and Hilgeman 1973).
  const auto reflectance = [](double cos) {
    const double t = std::sqrt(1 - (1 - cos * cos) / 2.25);
    const double s = (cos - 1.5 * t) / (cos + 1.5 * t), p = (1.5 * cos - t) / (1.5 * cos + t);
    return 0.5 * (s * s + p * p);
  };
  for (const float rho : {0.3f, 0.6f, 0.9f, 1.0f}) {
    const auto base = [&](double cos) { return std::min(0.96 * double{rho}, 1 - reflectance(cos)); };
    double mean = 0;
    constexpr int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) mean += base((i + 0.5) / kSteps) * 2 * (i + 0.5) / kSteps / kSteps;
    if (rho == 1) {
      EXPECT_NEAR(mean, 1 - 0.0918, 1e-4);  // Kelemen's form
    }
    const Bsdf bsdf = Bsdf::CoatedDiffuse(Rgb(rho), 1.5f, {0, 0});
    for (const double theta_o : {0.0, 40.0, 70.0, 85.0}) {
      for (const double theta_i : {5.0, 60.0, 80.0}) {
        const Vec3 wo = Direction(theta_o), wi = Direction(theta_i, 200);
        const double expected = base(wo.z) * base(wi.z) / (M_PI * mean) * double{wi.z};
        EXPECT_NEAR(bsdf.Evaluate(wo, wi).f_cos.r, expected, 1e-3 * expected) << theta_o << ' ' << theta_i;
      }
    }
  }
}

TEST(CoatedConductor, IsExactWhereBothAreFlat) {
  for (const double theta : {0.0, 50.0, 85.0}) {
    const Vec3 wo = Direction(theta, 0);
    const Outgoing walk =
        RandomWalk(1.5f, {0, 0}, Bsdf::Conductor(kGoldEta / 1.5f, kGoldK / 1.5f, {0, 0}), wo, 200000, 7);
    const auto s = Bsdf::CoatedConductor(1.5f, {0, 0}, kGoldEta, kGoldK, {0, 0}).Sample(wo, 0.5f, {0.5f, 0.5f});
    ASSERT_TRUE(s && s->delta);
    const TestResult r = TTest(walk[0], s->weight.r, SidakLevel(0.01, 3), 1e-5);
    EXPECT_TRUE(r.accepted) << theta << ": " << r.message;
  }
}

TEST(CoatedConductor, TheComparisonSeesAWrongIndex) {
  const Vec3 wo = Direction(50, 0);
  const Outgoing walk =
      RandomWalk(1.5f, {0, 0}, Bsdf::Conductor(kGoldEta / 1.5f, kGoldK / 1.5f, {0, 0}), wo, 200000, 5);
  const auto s = Bsdf::CoatedConductor(1.4f, {0, 0}, kGoldEta, kGoldK, {0, 0}).Sample(wo, 0.5f, {0.5f, 0.5f});
  ASSERT_TRUE(s);
  EXPECT_FALSE(TTest(walk[0], s->weight.r, 1e-4, 1e-5).accepted);
}

// The approximations of bsdf_coated.cpp, measured: the albedo of a gold base under a coat. The bounds are what was
// measured, rounded up.
TEST(CoatedConductor, StaysNearTheRandomWalk) {
  struct Bound {
    float coat, base;
    double bound;
  };
  for (const Bound& b :
       {Bound{0, 0.05f, 0.12}, {0, 0.3f, 0.045}, {0.1f, 0.0f, 0.065}, {0.1f, 0.2f, 0.045}, {0.3f, 0.3f, 0.135}}) {
    for (const double theta : {5.0, 45.0, 75.0}) {
      const Vec3 wo = Direction(theta, 0);
      const Outgoing walk = RandomWalk(
          1.5f, {b.coat, b.coat}, Bsdf::Conductor(kGoldEta / 1.5f, kGoldK / 1.5f, {b.base, b.base}), wo, 100000, 8);
      const Outgoing ours =
          Analytic(Bsdf::CoatedConductor(1.5f, {b.coat, b.coat}, kGoldEta, kGoldK, {b.base, b.base}), wo, 100000, 9);
      std::printf(
          "coat %.2f base %.2f at %2.0f: albedo %.4f, random walk %.4f, difference %+.4f; mean cosine %.4f, %.4f\n",
          b.coat, b.base, theta, ours[0].mean(), walk[0].mean(), ours[0].mean() - walk[0].mean(), ours[1].mean(),
          walk[1].mean());
      EXPECT_NEAR(ours[0].mean(), walk[0].mean(), b.bound);
      EXPECT_NEAR(ours[1].mean(), walk[1].mean(), b.bound);
    }
  }
}

TEST(CoatTable, TransmittanceOfAFlatCoatIsFresnels) {
  const CoatTable& table = CoatTable::For(1.5f);
  EXPECT_NEAR(table.Transmittance(1, CoatTable::RowOf(0)), 0.96f, 1e-4);
  // 1 - R of diffuse light from outside; Walsh 1926 / Egan and Hilgeman 1973: 0.0918 is reflected at index 1.5.
  EXPECT_NEAR(table.MeanTransmittance(CoatTable::RowOf(0)), 1 - 0.0918f, 3e-4);
  EXPECT_EQ(&table, &CoatTable::For(1.5f));
  EXPECT_NE(&table, &CoatTable::For(1.6f));
}

// The mean is that of what Transmittance() returns, between the rows too: the furnace depends on it. Caps between those
// tabulated cost a little more.
TEST(CoatTable, MeanIsThatOfTheInterpolatedTable) {
  const CoatTable& table = CoatTable::For(1.5f);
  for (const float alpha : {0.0f, 0.03f, 0.33f, 1.0f}) {
    const CoatTable::Row row = CoatTable::RowOf(alpha);
    for (const float cap : {1.0f, 0.99f, 0.955f, 0.9f, 0.5f, 0.1f, 0.001f}) {
      double sum = 0;
      constexpr int kSteps = 127 * 64;
      for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        sum += 2 * mu * std::min(table.Transmittance(static_cast<float>(mu), row), cap) / kSteps;
      }
      EXPECT_NEAR(table.MeanTransmittance(row, cap), sum, cap == 1 ? 1e-5 : 1e-3 * sum) << alpha << ' ' << cap;
    }
  }
}

TEST(CoatedDiffuse, TexturedReflectanceIsTheFactorys) {
  const Bsdf a = Bsdf::CoatedDiffuse(Rgb(0.2f), 1.5f, {0.1f, 0.1f}).WithReflectance({0.8f, 0.4f, 0.1f});
  const Bsdf b = Bsdf::CoatedDiffuse({0.8f, 0.4f, 0.1f}, 1.5f, {0.1f, 0.1f});
  const Vec3 wo = Direction(30), wi = Direction(50, 170);
  EXPECT_EQ(a.Evaluate(wo, wi).f_cos, b.Evaluate(wo, wi).f_cos);
  EXPECT_EQ(a.Evaluate(wo, wi).pdf, b.Evaluate(wo, wi).pdf);
}

}  // namespace
}  // namespace lodestar::test
