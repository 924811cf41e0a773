// Every map of core/math/warp.h against its density and its inverse; and the statistical machinery itself against wrong
// densities.
#include "core/math/warp.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

const double kLevel = SidakLevel(0.01, 12);

TEST(Warp, CosineHemisphereFollowsItsDensity) {
  const TestResult r =
      ChiSquareOnSphere([](Random& rng) { return std::optional(SquareToCosineHemisphere(rng.Next2D())); },
                        [](Vec3 w) { return CosineHemispherePdf(w.z); }, {.level = kLevel});
  EXPECT_TRUE(r.accepted) << r.message;
  EXPECT_NEAR(IntegrateSphere([](Vec3 w) { return CosineHemispherePdf(w.z); }).Total(), 1, 1e-5);
}

TEST(Warp, SphereFollowsItsDensity) {
  const TestResult r = ChiSquareOnSphere([](Random& rng) { return std::optional(SquareToSphere(rng.Next2D())); },
                                         [](Vec3) { return kUniformSpherePdf; }, {.level = kLevel});
  EXPECT_TRUE(r.accepted) << r.message;
}

TEST(Warp, CylindricalFollowsItsDensity) {
  const TestResult r =
      ChiSquareOnSphere([](Random& rng) { return std::optional(CylindricalToDirection(rng.Next2D())); },
                        [](Vec3) { return kUniformSpherePdf; }, {.level = kLevel});
  EXPECT_TRUE(r.accepted) << r.message;
}

TEST(Warp, CylindricalInverts) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const Vec2 u = random.Next2D();
    const Vec3 w = CylindricalToDirection(u);
    ASSERT_NEAR(LengthSquared(w), 1, 1e-6);
    const Vec2 back = DirectionToCylindrical(w);
    ASSERT_NEAR(back.x, u.x, 1e-6);
    // phi is lost at the poles, and wraps.
    const float s = SafeSqrt(1 - w.z * w.z);
    const float difference = std::fabs(back.y - u.y);
    ASSERT_LT(std::min(difference, 1 - difference) * s, 1e-6) << u.x << ' ' << u.y;
  }
  for (const Vec3 w : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{-1, 0, 0}, Vec3{-1, -0.0f, 0}, Vec3{0, -1, 0}}) {
    const Vec2 c = DirectionToCylindrical(w);
    EXPECT_TRUE(c.x >= 0 && c.x < 1 && c.y >= 0 && c.y < 1);
  }
}

TEST(Warp, DiskIsUniform) {
  constexpr int kRings = 16, kSectors = 16, kSamples = 200000;
  Random random(4);
  std::vector<double> observed(kRings * kSectors, 0.0),
      expected(kRings * kSectors, double{kSamples} / (kRings * kSectors));
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 d = SquareToDisk(random.Next2D());
    const double r2 = double{d.x} * d.x + double{d.y} * d.y;
    ASSERT_LE(r2, 1 + 1e-6);
    const double sector = (std::atan2(d.y, d.x) / (2 * M_PI) + 0.5) * kSectors;
    ++observed[std::min(static_cast<int>(r2 * kRings), kRings - 1) * kSectors +
               std::min(static_cast<int>(sector), kSectors - 1)];
  }
  const TestResult r = ChiSquareTest(observed, expected, kLevel);
  EXPECT_TRUE(r.accepted) << r.message;
}

// ---- inverses ----
// The renderer needs the cylindrical map's alone; the others are here, in double, to hold each map to its density.

struct Square {
  double x, y;
};

Square InverseOfDisk(double x, double y) {
  const double r = std::hypot(x, y);
  double a = 0, b = 0;
  if (std::fabs(x) > std::fabs(y)) {
    a = std::copysign(r, x);
    b = a * std::atan(y / x) * 4 / M_PI;
  } else if (r > 0) {
    b = std::copysign(r, y);
    a = b * std::atan(x / y) * 4 / M_PI;
  }
  return {(a + 1) / 2, (b + 1) / 2};
}

Square InverseOfTriangle(double x, double y) {
  return y > x ? Square{2 * x, x + y} : Square{x + y, 2 * y};
}

Square InverseOfSphere(double x, double y, double z) {
  const double phi = std::atan2(y, x) / (2 * M_PI);
  return {(1 - z) / 2, phi < 0 ? phi + 1 : phi};
}

Square InverseOfCosineHemisphere(double x, double y, double) {
  return InverseOfDisk(x, y);
}

Square InverseOfCylindrical(double x, double y, double z) {
  const Vec2 u = DirectionToCylindrical({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  return {u.x, u.y};
}

// Area of the square a unit of area around (0, 0), by central differences.
template <class Inverse>
double Jacobian(const Inverse& inverse, double h) {
  const Square x0 = inverse(-h, 0.0), x1 = inverse(h, 0.0), y0 = inverse(0.0, -h), y1 = inverse(0.0, h);
  return std::fabs((x1.x - x0.x) * (y1.y - y0.y) - (x1.y - x0.y) * (y1.x - y0.x)) / (4 * h * h);
}

// A seam of an inverse (where phi wraps, or two pieces of it meet) is near: differences across it say nothing.
bool NearSeam(Vec2 u, bool diagonals) {
  constexpr float kMargin = 0.03f;
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  return std::max(std::fabs(a), std::fabs(b)) > 1 - kMargin ||
         (diagonals && std::fabs(std::fabs(a) - std::fabs(b)) < kMargin);
}

TEST(Warp, MapsOfThePlaneInvertAndTheirInverseHasTheirDensity) {
  struct Map {
    const char* name;
    Vec2 (*warp)(Vec2);
    Square (*inverse)(double, double);
    double density;  // a unit of area; of the triangle's barycentric coordinates
  };
  for (const Map& map :
       {Map{"disk", SquareToDisk, InverseOfDisk, 1 / M_PI}, Map{"triangle", SquareToTriangle, InverseOfTriangle, 2}}) {
    Random random(7);
    for (int i = 0; i < 10000; ++i) {
      const Vec2 u = random.Next2D(), p = map.warp(u);
      const Square back = map.inverse(p.x, p.y);
      ASSERT_NEAR(back.x, u.x, 1e-6) << map.name << ' ' << u.x << ' ' << u.y;
      ASSERT_NEAR(back.y, u.y, 1e-6) << map.name << ' ' << u.x << ' ' << u.y;
      if (NearSeam(u, true)) continue;
      const auto around = [&](double x, double y) { return map.inverse(p.x + x, p.y + y); };
      ASSERT_NEAR(Jacobian(around, 1e-4), map.density, 1e-4 * map.density) << map.name << ' ' << u.x << ' ' << u.y;
    }
  }
}

TEST(Warp, MapsOfTheSphereInvertAndTheirInverseHasTheirDensity) {
  struct Map {
    const char* name;
    Vec3 (*warp)(Vec2);
    Square (*inverse)(double, double, double);
    double (*density)(Vec3);
    bool diagonals;
    double round_trip, h, tolerance;  // the cylindrical inverse is of single precision
  };
  const auto uniform = [](Vec3) { return double{kUniformSpherePdf}; };
  for (const Map& map :
       {Map{"sphere", SquareToSphere, InverseOfSphere, uniform, false, 2e-6, 1e-4, 1e-4},
        Map{"cylindrical", CylindricalToDirection, InverseOfCylindrical, uniform, false, 2e-6, 1e-2, 1e-2},
        Map{"cosine hemisphere", SquareToCosineHemisphere, InverseOfCosineHemisphere,
            [](Vec3 w) { return double{CosineHemispherePdf(w.z)}; }, true, 1e-6, 1e-4, 1e-3}}) {
    Random random(8);
    for (int i = 0; i < 10000; ++i) {
      const Vec2 u = random.Next2D();
      if (NearSeam(u, map.diagonals)) continue;
      const Vec3 w = map.warp(u);
      const Square back = map.inverse(w.x, w.y, w.z);
      ASSERT_NEAR(back.x, u.x, map.round_trip) << map.name << ' ' << u.x << ' ' << u.y;
      ASSERT_NEAR(back.y, u.y, map.round_trip) << map.name << ' ' << u.x << ' ' << u.y;
      // Along two tangents of w, back on the sphere.
      const Vec3 s = Normalize(Cross(w, std::fabs(w.x) > 0.7f ? Vec3{0, 1, 0} : Vec3{1, 0, 0})), t = Cross(w, s);
      const auto around = [&](double x, double y) {
        const double v[3] = {w.x + x * s.x + y * t.x, w.y + x * s.y + y * t.y, w.z + x * s.z + y * t.z};
        const double length = std::hypot(v[0], v[1], v[2]);
        return map.inverse(v[0] / length, v[1] / length, v[2] / length);
      };
      const double density = map.density(w);
      ASSERT_NEAR(Jacobian(around, map.h), density, map.tolerance * density) << map.name << ' ' << u.x << ' ' << u.y;
    }
  }
}

TEST(Warp, DiskOfTheExtremeCorners) {
  for (const float x : {0.0f, 0.5f, kOneMinusEpsilon}) {
    for (const float y : {0.0f, 0.5f, kOneMinusEpsilon}) {
      const Vec3 w = SquareToCosineHemisphere({x, y});
      EXPECT_TRUE(IsFinite(w));
      EXPECT_GE(w.z, 0);
      EXPECT_NEAR(LengthSquared(w), 1, 1e-6);
    }
  }
}

TEST(Warp, TriangleIsUniform) {
  // Barycentric cells: a square grid folded by the diagonal, whose cells below it have equal area.
  constexpr int kGrid = 12, kSamples = 200000;
  Random random(5);
  std::vector<double> observed(kGrid * kGrid, 0.0), expected(kGrid * kGrid, 0.0);
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; i + j < kGrid; ++j)
      expected[i * kGrid + j] = (i + j == kGrid - 1 ? 1.0 : 2.0) * kSamples / (kGrid * kGrid);
  }
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 b = SquareToTriangle(random.Next2D());
    ASSERT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1 + 1e-6f);
    int x = std::min(static_cast<int>(b.x * kGrid), kGrid - 1), y = std::min(static_cast<int>(b.y * kGrid), kGrid - 1);
    if (x + y >= kGrid) (x > 0 ? x : y)--;
    ++observed[x * kGrid + y];
  }
  const TestResult r = ChiSquareTest(observed, expected, kLevel);
  EXPECT_TRUE(r.accepted) << r.message;
}

// ---- the machinery rejects what is wrong ----

TEST(Statistical, ChiSquareRejectsAWrongDensity) {
  const auto cosine = [](Random& rng) { return std::optional(SquareToCosineHemisphere(rng.Next2D())); };
  EXPECT_FALSE(ChiSquareOnSphere(cosine, [](Vec3 w) { return w.z > 0 ? 2 * kUniformSpherePdf : 0; }, {.level = kLevel})
                   .accepted);
  EXPECT_FALSE(
      ChiSquareOnSphere(cosine, [](Vec3 w) { return 0.97 * CosineHemispherePdf(w.z); }, {.level = kLevel}).accepted);
  EXPECT_FALSE(
      ChiSquareOnSphere(cosine, [](Vec3 w) { return 1.02 * CosineHemispherePdf(w.z); }, {.level = kLevel}).accepted);
  EXPECT_FALSE(
      ChiSquareOnSphere(cosine, [](Vec3 w) { return CosineHemispherePdf(w.z) * (1 + 0.1 * w.x); }, {.level = kLevel})
          .accepted);
  EXPECT_FALSE(
      ChiSquareOnSphere([](Random&) { return std::optional<Vec3>(); }, [](Vec3) { return 0.0; }, {.level = kLevel})
          .accepted);
}

TEST(Statistical, ChiSquareCountsFailedSamples) {
  const auto half = [](Random& rng) {
    return rng.Next1D() < 0.25f ? std::nullopt : std::optional(SquareToCosineHemisphere(rng.Next2D()));
  };
  const TestResult r =
      ChiSquareOnSphere(half, [](Vec3 w) { return 0.75 * CosineHemispherePdf(w.z); }, {.level = kLevel});
  EXPECT_TRUE(r.accepted) << r.message;
  EXPECT_FALSE(ChiSquareOnSphere(half, [](Vec3 w) { return CosineHemispherePdf(w.z); }, {.level = kLevel}).accepted);
}

TEST(Statistical, TTestsTellMeansApart) {
  Random random(6);
  Moments a, b, shifted;
  for (int i = 0; i < 100000; ++i) {
    a.Add(random.Next1D());
    b.Add(2 * random.Next1D() - 0.5);
    shifted.Add(random.Next1D() + 0.01);
  }
  EXPECT_TRUE(TTest(a, 0.5, kLevel).accepted);
  EXPECT_TRUE(WelchTest(a, b, kLevel).accepted);
  EXPECT_FALSE(TTest(a, 0.51, kLevel).accepted);
  EXPECT_TRUE(TTest(a, 0.51, kLevel, 0.01).accepted);
  EXPECT_FALSE(WelchTest(a, shifted, kLevel).accepted);
}

TEST(Statistical, ConstantSamplesNeedTheExactValue) {
  Moments constant;
  for (int i = 0; i < 10; ++i) constant.Add(0.25);
  EXPECT_TRUE(TTest(constant, 0.25, 1e-3).accepted);
  EXPECT_FALSE(TTest(constant, 0.26, 1e-3).accepted);
}

TEST(Statistical, SidakLevelKeepsTheOverallLevel) {
  EXPECT_NEAR(1 - std::pow(1 - SidakLevel(0.01, 50), 50), 0.01, 1e-12);
  EXPECT_DOUBLE_EQ(SidakLevel(0.05, 1), 0.05);
}

TEST(Statistical, ImpossibleBinsReject) {
  const std::vector<double> observed = {50, 50, 1}, expected = {50, 51, 0};
  EXPECT_FALSE(ChiSquareTest(observed, expected, 1e-3).accepted);
}

TEST(Statistical, IntegralOfANarrowLobe) {
  // A von Mises-Fisher lobe of kappa 1e4, oblique.
  const Vec3 axis = Normalize(Vec3{0.8f, 0.1f, 0.3f});
  const double kappa = 1e4;
  const auto vmf = [&](Vec3 w) {
    const Vec3 d = w - axis;
    return kappa / (2 * M_PI) * std::exp(-kappa * 0.5 * double{LengthSquared(d)});
  };
  EXPECT_NEAR(IntegrateSphere(vmf, axis).upper, 1, 1e-3);
}

}  // namespace
}  // namespace lodestar::test
