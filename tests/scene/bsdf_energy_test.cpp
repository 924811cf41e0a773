// Energy conservation, reciprocity, and parameters at their ends.
#include <gtest/gtest.h>

#include <functional>

#include "tests/scene/bsdf_cases.h"
#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

// Mean over wi of f |cos|, the eta^2 of refracted radiance taken out: the part of the flux that leaves. A sampler that
// claimed another density than its own would multiply it by `wrong`.
Moments Furnace(const Bsdf& bsdf, Vec3 wo, int samples, double wrong = 1) {
  Random random(3);
  Moments m;
  for (int i = 0; i < samples; ++i) {
    const float u_lobe = random.Next1D();
    const auto s = bsdf.Sample(wo, u_lobe, random.Next2D());
    m.Add(s ? wrong * double{MaxComponent(s->weight)} * s->eta * s->eta : 0);
  }
  return m;
}

const std::vector<double> kAngles = {0, 30, 60, 80, 89, 120, 179};

TEST(BsdfEnergy, NothingGainsEnergy) {
  for (const BsdfCase& c : BsdfCases()) {
    for (const double theta : kAngles) {
      const Moments m = Furnace(c.bsdf, Direction(theta), 20000);
      // 2e-3: the interpolation error of a coat's tables.
      const bool coat = c.name.starts_with("coated");
      EXPECT_LE(m.mean() - 5 * m.standard_error(), 1 + (coat ? 2e-3 : 1e-4)) << c.name << " at " << theta;
    }
  }
}

TEST(BsdfEnergy, NoAlbedoOneMaterialGainsEnergy) {
  const Rgb white_eta(0.01f), white_k(100);  // reflects 0.99999
  std::vector<BsdfCase> cases;
  for (const float alpha : {1e-4f, 0.01f, 0.1f, 0.3f, 0.6f, 1.0f}) {
    for (const float coat : {0.0f, 0.05f, 0.3f, 1.0f}) {
      for (const float eta : {1.0f, 1.1f, 1.5f, 2.5f}) {
        cases.push_back(
            {"coated conductor", Bsdf::CoatedConductor(eta, {coat, coat}, white_eta, white_k, {alpha, alpha})});
      }
    }
    for (const float eta : {1.0001f, 1.2f, 1.5f, 2.5f}) {
      cases.push_back({"coated diffuse", Bsdf::CoatedDiffuse(Rgb(1), eta, {alpha, alpha})});
      cases.push_back({"coated diffuse, anisotropic", Bsdf::CoatedDiffuse(Rgb(1), eta, {alpha, 0.25f * alpha})});
      cases.push_back({"dielectric", Bsdf::Dielectric(eta, {alpha, alpha})});
    }
    cases.push_back({"conductor", Bsdf::Conductor(white_eta, white_k, {alpha, alpha})});
  }
  double worst = 0;
  for (const BsdfCase& c : cases) {
    for (const double theta : {0.0, 45.0, 75.0, 88.0}) {
      const Moments m = Furnace(c.bsdf, Direction(theta), 4000);
      // 2e-3: the interpolation error of the tables.
      EXPECT_LE(m.mean() - 5 * m.standard_error(), 1 + 2e-3) << c.name << " at " << theta;
      worst = std::max(worst, m.mean() - 5 * m.standard_error());
    }
  }
  RecordProperty("largest_albedo", std::to_string(worst));
}

TEST(BsdfEnergy, TheSmoothWhiteFurnaceIsExact) {
  for (const double theta : kAngles) {
    const Vec3 wo = Direction(theta);
    for (const float eta : {1.0f, 1.0001f, 1.5f, 2.4f, 1 / 1.5f}) {
      EXPECT_NEAR(Furnace(Bsdf::Dielectric(eta, {0, 0}), wo, 1000).mean(), 1, 1e-5) << eta << " at " << theta;
      EXPECT_NEAR(Furnace(Bsdf::ThinDielectric(eta), wo, 1000).mean(), 1, 1e-5) << eta << " at " << theta;
    }
    const double level = SidakLevel(0.01, 50);
    EXPECT_NEAR(Furnace(Bsdf::Diffuse(Rgb(1)), wo, 1000).mean(), 1, 1e-5);
    EXPECT_NEAR(Furnace(Bsdf::DiffuseTransmission(Rgb(0.5f), Rgb(0.5f)), wo, 1000).mean(), 1, 1e-5);
    for (const float eta : {1.0f, 1.3f, 1.5f, 2.0f}) {
      // 1e-3: the table's transmittance stands in for Fresnel's.
      const TestResult r = TTest(Furnace(Bsdf::CoatedDiffuse(Rgb(1), eta, {0, 0}), wo, 100000), 1, level, 1e-3);
      EXPECT_TRUE(r.accepted) << "coated diffuse " << eta << " at " << theta << ": " << r.message;
      EXPECT_NEAR(Furnace(Bsdf::CoatedConductor(eta, {0, 0}, Rgb(1e-3f), Rgb(1e3f), {0, 0}), wo, 100).mean(), 1, 1e-4);
    }
  }
}

TEST(BsdfEnergy, AFurnaceSeesADensityThatIsOnePercentWrong) {
  const Rgb white_eta(0.01f), white_k(100);
  const std::vector<BsdfCase> white = {
      {"diffuse", Bsdf::Diffuse(Rgb(1))},
      {"smooth dielectric", Bsdf::Dielectric(1.5f, {0, 0})},
      {"dielectric 0.05", Bsdf::Dielectric(1.5f, {0.05f, 0.05f})},
      {"conductor 0.02", Bsdf::Conductor(white_eta, white_k, {0.02f, 0.02f})},
      {"coated diffuse", Bsdf::CoatedDiffuse(Rgb(1), 1.5f, {0.3f, 0.3f})},
      {"coated conductor", Bsdf::CoatedConductor(1.5f, {0, 0}, white_eta, white_k, {0, 0})},
      {"diffuse transmission", Bsdf::DiffuseTransmission(Rgb(0.5f), Rgb(0.5f))},
  };
  for (const BsdfCase& c : white) {
    for (const double theta : {0.0, 30.0}) {
      const Moments right = Furnace(c.bsdf, Direction(theta), 20000),
                    wrong = Furnace(c.bsdf, Direction(theta), 20000, 1.01);
      EXPECT_LE(right.mean() - 5 * right.standard_error(), 1 + 2e-3) << c.name << " at " << theta;
      EXPECT_GT(wrong.mean() - 5 * wrong.standard_error(), 1 + 2e-3) << c.name << " at " << theta;
    }
  }
}

// What leaves a white microsurface at the first reflection, seen from straight above (decision 0019): int D(m) m.z
// G2 / G1 over the slopes t = tan^2 theta_m, whose cumulative distribution under D(m) m.z is t / (t + alpha^2).
double FirstReflectionFromAbove(double alpha) {
  constexpr int kSteps = 100000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double u = (i + 0.5) / kSteps, t = alpha * alpha * u / (1 - u);
    const double c = (1 - t) / (1 + t);  // of the mirrored direction, at twice the normal's angle
    if (c > 0) sum += 2 * c / (c + std::sqrt(alpha * alpha * (1 - c * c) + c * c));
  }
  return sum / kSteps;
}

TEST(BsdfEnergy, AWhiteConductorKeepsWhatTheFirstReflectionLetsGo) {
  const double level = SidakLevel(0.01, 5);
  for (const float alpha : {0.1f, 0.3f, 0.5f, 0.8f, 1.0f}) {
    const double expected = FirstReflectionFromAbove(alpha);
    const Moments m = Furnace(Bsdf::Conductor(Rgb(1e-3f), Rgb(1e3f), {alpha, alpha}), Direction(0), 100000);
    const TestResult r = TTest(m, expected, level);
    EXPECT_TRUE(r.accepted) << alpha << ": " << r.message;
    EXPECT_FALSE(TTest(m, 1.02 * expected, level).accepted) << alpha;  // a wrong one is seen
  }
  EXPECT_NEAR(FirstReflectionFromAbove(1), 1 - std::log(2.0), 1e-6);
}

// The largest relative difference between f(wo, wi) and what reciprocity makes of f(wi, wo): the same for reflection,
// eta_o^2 f(wo, wi) = eta_i^2 f(wi, wo) for transmission, each eta that of the direction's side (our f carries radiance
// from wi to wo). `f_cos` as Bsdf::Evaluate gives it.
double Asymmetry(const BsdfCase& c, const std::function<Rgb(Vec3 wo, Vec3 wi)>& f_cos) {
  Random random(17);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 wo = SquareToSphere(random.Next2D()), wi = SquareToSphere(random.Next2D());
    if (std::fabs(wo.z) < 0.01f || std::fabs(wi.z) < 0.01f) continue;
    const Rgb forward = f_cos(wo, wi) / std::fabs(wi.z);
    const Rgb backward = f_cos(wi, wo) / std::fabs(wo.z);
    float ratio = 1;  // f(wo, wi) / f(wi, wo)
    if (wo.z * wi.z < 0 && c.bsdf.kind() == Bsdf::Kind::kDielectric) {
      const float eta = c.name.find("1.33") != std::string::npos  ? 1.33f
                        : c.name.find("1.8") != std::string::npos ? 1.8f
                        : c.name.find("1 /") != std::string::npos ? 1 / 1.5f
                                                                  : 1.5f;
      ratio = wo.z > 0 ? 1 / (eta * eta) : eta * eta;
      // Microfacets seen edge-on: their cosine is the difference of rounded numbers.
      const Vec3 m = Normalize(wo.z > 0 ? wo + wi * eta : wo * eta + wi);
      if (std::min(AbsDot(wo, m), AbsDot(wi, m)) < 0.05f) continue;
    }
    for (int k = 0; k < 3; ++k) {
      const double difference = std::fabs(forward[k] - backward[k] * ratio) - 1e-6;
      // A difference that is no number is not small.
      if (!(difference <= 0)) worst = std::isfinite(difference) ? std::max(worst, difference / forward[k]) : 1e30;
    }
  }
  return worst;
}

TEST(BsdfEnergy, Reciprocity) {
  for (const BsdfCase& c : BsdfCases()) {
    if (!c.bsdf.HasSmoothLobes()) continue;
    EXPECT_LE(Asymmetry(c, [&](Vec3 wo, Vec3 wi) { return c.bsdf.Evaluate(wo, wi).f_cos; }), 2e-3) << c.name;
    // One per cent that depends on wo alone is seen.
    EXPECT_GT(Asymmetry(c, [&](Vec3 wo, Vec3 wi) { return c.bsdf.Evaluate(wo, wi).f_cos * (1 + 0.01f * wo.x); }), 2e-3)
        << c.name;
  }
}

TEST(BsdfEnergy, ExtremeParametersStayFinite) {
  std::vector<BsdfCase> cases;
  for (const float alpha : {0.0f, 1e-4f, 9.99e-4f, 1e-3f, 0.5f, 1.0f}) {
    for (const float eta : {1.0f, 1.0001f, 0.5f, 1.5f, 10.0f}) {
      cases.push_back({"dielectric", Bsdf::Dielectric(eta, {alpha, alpha})});
      cases.push_back({"dielectric, anisotropic", Bsdf::Dielectric(eta, {alpha, 0.5f})});
      if (eta == 10.0f || eta == 0.5f) continue;
      for (const float albedo : {0.0f, 1.0f})
        cases.push_back({"coated diffuse", Bsdf::CoatedDiffuse(Rgb(albedo), eta, {alpha, alpha})});
      for (const float k : {0.0f, 1e-3f, 10.0f}) {
        cases.push_back(
            {"coated conductor", Bsdf::CoatedConductor(eta, {alpha, alpha}, Rgb(1), Rgb(k), {0.5f, alpha})});
        cases.push_back({"coated conductor", Bsdf::CoatedConductor(eta, {0, 0}, Rgb(1), Rgb(k), {alpha, alpha})});
      }
    }
    for (const float k : {0.0f, 1e-3f, 1e3f}) {
      for (const float eta : {1.0f, 1e-3f, 10.0f}) {
        cases.push_back({"conductor", Bsdf::Conductor(Rgb(eta), Rgb(k), {alpha, alpha})});
        cases.push_back({"conductor, anisotropic", Bsdf::Conductor(Rgb(eta), Rgb(k), {alpha, 1})});
      }
    }
  }
  cases.push_back({"black", Bsdf::Diffuse(Rgb(0))});
  cases.push_back({"black transmission", Bsdf::DiffuseTransmission(Rgb(0), Rgb(0))});
  cases.push_back({"thin 1", Bsdf::ThinDielectric(1)});

  std::vector<Vec3> directions;
  for (const float z : {1.0f, 0.5f, 1e-2f, 1e-4f, 1e-7f, 1e-20f, 1e-40f, 0.0f}) {
    for (const float sign : {1.0f, -1.0f}) {
      directions.push_back({std::sqrt(1 - z * z), 0, sign * z});
      directions.push_back({-0.6f * std::sqrt(1 - z * z), 0.8f * std::sqrt(1 - z * z), sign * z});
    }
  }
  const std::vector<float> us = {0.0f, 1e-7f, 0.25f, 0.5f, 0.75f, kOneMinusEpsilon};
  for (const BsdfCase& c : cases) {
    for (const Vec3 wo : directions) {
      for (const Vec3 wi : directions) {
        const BsdfValue v = c.bsdf.Evaluate(wo, wi);
        ASSERT_TRUE(IsFinite(v.f_cos) && std::isfinite(v.pdf) && MinComponent(v.f_cos) >= 0 && v.pdf >= 0) << c.name;
        ASSERT_TRUE(v.pdf > 0 || IsBlack(v.f_cos)) << c.name << ' ' << wo.z << ' ' << wi.z << ' ' << v.f_cos.r;
      }
      const float p = c.bsdf.DeltaProbability(wo);
      ASSERT_TRUE(p >= 0 && p <= 1) << c.name;
      const Rgb albedo = c.bsdf.Albedo(wo);
      ASSERT_TRUE(IsFinite(albedo) && MinComponent(albedo) >= 0 && MaxComponent(albedo) <= 1.01f)
          << c.name << ' ' << wo.z << ' ' << albedo.r;
      for (const float u_lobe : us) {
        for (const float ux : us) {
          for (const float uy : us) {
            const auto s = c.bsdf.Sample(wo, u_lobe, {ux, uy});
            if (!s) continue;
            ASSERT_TRUE(IsFinite(s->wi) && IsFinite(s->weight) && MinComponent(s->weight) >= 0) << c.name;
            ASSERT_TRUE(std::isfinite(s->pdf) && s->pdf > 0 && s->eta > 0) << c.name << ' ' << s->pdf;
            ASSERT_NEAR(LengthSquared(s->wi), 1, 1e-4) << c.name << ' ' << wo.z;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace lodestar::test
