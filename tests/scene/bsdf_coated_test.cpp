// The coated materials against a brute-force random walk between the interface and the base, and what the
// approximations cost.
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
// transport between two parallel boundaries; the layer absorbs exp(-thickness / |cos|) on each crossing, and the walk
// ends after coat.max_depth interactions.
Outgoing RandomWalk(float interface_eta, Vec2 interface_alpha, const Bsdf& base, const CoatOptions& coat, Vec3 wo,
                    int samples, uint64_t seed) {
  const Bsdf interface = Bsdf::Dielectric(interface_eta, interface_alpha);
  Random random(seed);
  Outgoing out;
  const auto sample = [&](const Bsdf& bsdf, Vec3 w) {
    const float u_lobe = random.Next1D();
    return bsdf.Sample(w, u_lobe, random.Next2D());
  };
  const int limit = coat.max_depth > 0 ? coat.max_depth : 1000;
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
      for (int depth = 0; depth < limit; ++depth) {
        beta *= std::exp(-double{coat.thickness} / std::fabs(w.z));
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

TEST(CoatedDiffuse, IsTheExpectationOfTheRandomWalk) {
  const CoatOptions pbrt, lossless{.thickness = 0, .max_depth = 0}, thick{.thickness = 0.1f, .max_depth = 5};
  constexpr int kSamples = 40000;
  const double level = SidakLevel(0.01, 4 * 3 * 3 * 3 * kMoments);
  double worst = 0;
  uint64_t seed = 1000;
  for (const float alpha : {0.0f, 0.05f, 0.1f, 0.3f}) {
    for (const float eta : {1.2f, 1.5f, 2.0f}) {
      for (const CoatOptions& coat : {pbrt, lossless, thick}) {
        const float albedo = coat.thickness == 0.1f ? 0.4f : 0.9f;
        for (const double theta : {10.0, 55.0, 80.0}) {
          const Vec3 wo = Direction(theta, 0);
          const Outgoing walk = RandomWalk(eta, {alpha, alpha}, Bsdf::Diffuse(Rgb(albedo)), coat, wo, kSamples, ++seed);
          const Outgoing ours =
              Analytic(Bsdf::CoatedDiffuse(Rgb(albedo), eta, {alpha, alpha}, coat), wo, kSamples, ++seed);
          for (int i = 0; i < kMoments; ++i) {
            // 1e-3: the tables.
            const TestResult r = WelchTest(walk[i], ours[i], level, 1e-3);
            EXPECT_TRUE(r.accepted) << "alpha " << alpha << " eta " << eta << " thickness " << coat.thickness
                                    << " theta " << theta << " moment " << i << ": " << r.message;
          }
          worst = std::max(worst, std::fabs(walk[0].mean() - ours[0].mean()));
        }
      }
    }
  }
  std::printf("largest difference of an albedo from the random walk: %.4f\n", worst);
}

TEST(CoatedDiffuse, TheComparisonSeesAWrongModel) {
  const Vec3 wo = Direction(40, 0);
  const CoatOptions coat;
  const Outgoing walk = RandomWalk(1.5f, {0.1f, 0.1f}, Bsdf::Diffuse(Rgb(0.9f)), coat, wo, 40000, 5);
  const Outgoing lossless =
      Analytic(Bsdf::CoatedDiffuse(Rgb(0.9f), 1.5f, {0.1f, 0.1f}, {.thickness = 0, .max_depth = 10}), wo, 40000, 6);
  EXPECT_FALSE(WelchTest(walk[0], lossless[0], 1e-4, 1e-3).accepted);
}

TEST(CoatedConductor, IsExactWhereBothAreFlat) {
  for (const double theta : {0.0, 50.0, 85.0}) {
    const Vec3 wo = Direction(theta, 0);
    const Outgoing walk =
        RandomWalk(1.5f, {0, 0}, Bsdf::Conductor(kGoldEta / 1.5f, kGoldK / 1.5f, {0, 0}), {}, wo, 200000, 7);
    const auto s = Bsdf::CoatedConductor(1.5f, {0, 0}, kGoldEta, kGoldK, {0, 0}).Sample(wo, 0.5f, {0.5f, 0.5f});
    ASSERT_TRUE(s && s->delta);
    const TestResult r = TTest(walk[0], s->weight.r, SidakLevel(0.01, 3), 1e-5);
    EXPECT_TRUE(r.accepted) << theta << ": " << r.message;
  }
}

// The approximations of bsdf_coated.cpp, measured: the albedo of a gold base under a coat. The bounds are what was
// measured, rounded up.
TEST(CoatedConductor, StaysNearTheRandomWalk) {
  struct Bound {
    float coat, base;
    double bound;
  };
  for (const Bound& b :
       {Bound{0, 0.05f, 0.055}, {0, 0.3f, 0.035}, {0.1f, 0.0f, 0.15}, {0.1f, 0.2f, 0.045}, {0.3f, 0.3f, 0.12}}) {
    for (const double theta : {5.0, 45.0, 75.0}) {
      const Vec3 wo = Direction(theta, 0);
      const Outgoing walk = RandomWalk(
          1.5f, {b.coat, b.coat}, Bsdf::Conductor(kGoldEta / 1.5f, kGoldK / 1.5f, {b.base, b.base}), {}, wo, 100000, 8);
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
  const CoatTable& table = CoatTable::For(1.5f, 0);
  EXPECT_NEAR(table.Transmittance(1, CoatTable::RowOf(0)), 0.96f, 1e-4);
  // 1 - R of diffuse light from outside; Walsh 1926 / Egan and Hilgeman 1973: 0.0918 is reflected at index 1.5, 0.5963
  // from inside.
  EXPECT_NEAR(table.MeanTransmittance(CoatTable::RowOf(0)), 1 - 0.0918f, 3e-4);
  EXPECT_NEAR(table.InternalReflectance(CoatTable::RowOf(0)), 0.5963f, 3e-4);
  EXPECT_EQ(&table, &CoatTable::For(1.5f, 0));
  EXPECT_NE(&table, &CoatTable::For(1.5f, 0.01f));
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
