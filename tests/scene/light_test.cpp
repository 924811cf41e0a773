// Every light: its samples follow the density it states, the density asked for afterwards is the same, and the
// irradiance is the analytic one.
#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "core/base/error.h"
#include "core/image/image.h"
#include "core/scene/light_environment.h"
#include "core/scene/light_shapes.h"
#include "tests/scene/scene_builder.h"
#include "tests/support/statistical.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using test::Moments;
using test::Random;
using test::SceneBuilder;

const double kLevel = test::SidakLevel(0.01, 60);

// Irradiance at p on a surface with normal n: by light sampling, where there is an environment combined with cosine
// sampling of it (balance heuristic), since light sampling leaves its dim part out.
Moments Irradiance(const Scene& scene, Vec3 p, Vec3 n, int samples, uint64_t seed = 1) {
  Random random(seed);
  Moments moments;
  for (int i = 0; i < samples; ++i) {
    const float pick = random.Next1D();
    const auto s = scene.SampleLight(p, pick, random.Next2D());
    double value = 0;
    if (s && Dot(n, s->wi) > 0) {
      Ray ray{p, s->wi, kInfinity};
      if (!s->infinite) {
        ray.t_max = Length(s->target - p);
        ray.direction = (s->target - p) / ray.t_max;
      }
      const float cosine = Dot(n, s->wi), other_pdf = s->infinite && !s->delta ? cosine * kInvPi : 0;
      if (scene.Unoccluded(ray)) value = double(s->radiance.g) / (s->pdf + other_pdf) * cosine;
    }
    if (scene.needs().environment) {
      const Vec3 local = SquareToCosineHemisphere(random.Next2D()), w = Frame::FromNormal(n).ToWorld(local);
      const auto seen = scene.Environment(w);
      const float pdf = CosineHemispherePdf(local.z);
      if (pdf > 0 && scene.Unoccluded({p, w, kInfinity})) value += double(seen.radiance.g) * local.z / (pdf + seen.pdf);
    }
    moments.Add(value);
  }
  return moments;
}

void ExpectIrradiance(const Scene& scene, Vec3 p, Vec3 n, double expected, int samples = 100000) {
  const auto result = test::TTest(Irradiance(scene, p, n, samples), expected, kLevel, 3e-6 * expected);
  EXPECT_TRUE(result.accepted) << result.message;
}

// Density of the direction as the path kernel would ask: by a ray that hits the light.
double PdfByRay(const Scene& scene, Vec3 p, Vec3 w) {
  Hit hit;
  const Ray ray{p, w, kInfinity};
  if (!scene.Intersect(ray, &hit)) return 0;
  const auto si = scene.Interaction(hit);
  return si.light < 0 || IsBlack(scene.Emitted(si, -w)) ? 0 : scene.LightPdf(p, si);
}

// Do the samples fill the light as the density asked for by rays says? Eight regions around the light's middle: the
// share of samples in each against the density's integral over it, by uniform rays in the light's cone. (The chi-square
// test's quadrature does not take a light's sharp edges.)
bool SamplesFollowDensity(const Scene& scene, Vec3 p, const std::function<double(Vec3)>& density,
                          std::string* message) {
  constexpr int kSamples = 40000, kRays = 120000;
  Random random(6);
  std::vector<Vec3> samples;
  Vec3 middle;
  for (int i = 0; i < kSamples; ++i) {
    const float pick = random.Next1D();
    if (const auto s = scene.SampleLight(p, pick, random.Next2D())) {
      samples.push_back(s->wi);
      middle += s->wi;
    }
  }
  // Lights all around have no middle.
  middle = Length(middle) > 0.05f * float(samples.size()) ? Normalize(middle) : Vec3{0, 0, 1};
  float cone = 1;
  for (const Vec3 w : samples) cone = std::min(cone, Dot(w, middle));
  cone = std::max(1 - (1 - cone) * 1.02f, -1.0f);
  const Frame frame = Frame::FromNormal(middle);
  const auto region = [&](Vec3 w) {
    const Vec3 local = frame.ToLocal(w);
    return (local.x > 0) + 2 * (local.y > 0) + 4 * (1 - local.z > 0.4f * (1 - cone));
  };
  std::array<Moments, 8> sampled, integral;
  for (const Vec3 w : samples)
    for (int k = 0; k < 8; ++k) sampled[k].Add(region(w) == k);
  for (size_t i = samples.size(); i < kSamples; ++i)
    for (int k = 0; k < 8; ++k) sampled[k].Add(0);
  for (int i = 0; i < kRays; ++i) {
    const Vec2 u = random.Next2D();
    const float z = 1 - u.x * (1 - cone), r = SafeSqrt(1 - z * z);
    const auto [sin, cos] = SinCos(2 * kPi * u.y);
    const Vec3 w = frame.ToWorld({r * cos, r * sin, z});
    const double value = density(w) * 2 * double(kPi) * (1 - double(cone));
    for (int k = 0; k < 8; ++k) integral[k].Add(region(w) == k ? value : 0.0);
  }
  for (int k = 0; k < 8; ++k) {
    if (sampled[k].mean() == 0 && integral[k].mean() == 0) continue;
    const auto result = test::WelchTest(sampled[k], integral[k], kLevel / 8, 1e-4);
    if (!result.accepted) {
      *message = "region " + std::to_string(k) + ": " + result.message;
      return false;
    }
  }
  return true;
}

void ExpectConsistent(const Scene& scene, Vec3 p) {
  Random random(5);
  int compared = 0, sampled = 0;
  for (int i = 0; i < 2000; ++i) {
    const float pick = random.Next1D();
    const auto s = scene.SampleLight(p, pick, random.Next2D());
    if (!s) continue;
    ++sampled;
    EXPECT_NEAR(Length(s->wi), 1, 1e-5);
    Hit hit;
    const Ray ray{p, s->wi, kInfinity};
    if (!scene.Intersect(ray, &hit) || Dot(scene.Interaction(hit).ng, -s->wi) < 0.05f) continue;  // an edge
    ++compared;
    EXPECT_NEAR(PdfByRay(scene, p, s->wi) / s->pdf, 1, 2e-3);
  }
  EXPECT_GT(sampled, 500);
  EXPECT_GT(compared, sampled * 0.75);
  std::string message;
  EXPECT_TRUE(SamplesFollowDensity(
      scene, p, [&](Vec3 w) { return PdfByRay(scene, p, w); }, &message))
      << message;
}

// Lambert's formula for a polygon wholly above the horizon.
double PolygonIrradiance(Vec3 p, Vec3 n, const std::vector<Vec3>& corners, double radiance) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = Normalize(corners[i] - p), b = Normalize(corners[(i + 1) % corners.size()] - p);
    const Vec3 c = Cross(a, b);
    sum += std::acos(std::clamp(double(Dot(a, b)), -1.0, 1.0)) * Dot(Normalize(c), n);
  }
  return std::fabs(sum) / 2 * radiance;
}

std::shared_ptr<const Scene> TriangleScene() {
  SceneBuilder b;
  TriangleMesh mesh;
  mesh.positions = {{-1, -0.5f, 2}, {1.5f, -1, 2.2f}, {0.3f, 1.7f, 1.8f}};
  mesh.triangles = {{0, 2, 1}};  // faces the origin
  b.AddLight(mesh, Rgb(2, 3, 4));
  return b.Compile();
}
const std::vector<Vec3> kTriangle{{-1, -0.5f, 2}, {1.5f, -1, 2.2f}, {0.3f, 1.7f, 1.8f}};

TEST(TriangleLight, NearAndFar) {
  const auto scene = TriangleScene();
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{0.2f, 0.1f, 1.6f}, Vec3{3, -2, -9}, Vec3{4, 0, 1}}) {
    SCOPED_TRACE(p.x);
    ExpectConsistent(*scene, p);
    const Vec3 n = Normalize(Vec3{0.3f, 0.4f, 2} - p);
    bool above = true;
    for (const Vec3 c : kTriangle) above &= Dot(c - p, n) > 0;
    if (above) ExpectIrradiance(*scene, p, n, PolygonIrradiance(p, n, kTriangle, 3));
  }
  EXPECT_FALSE(scene->SampleLight({0, 0, 5}, 0.5f, {0.3f, 0.4f}));  // behind
}

TEST(TriangleLight, AWrongDensityIsRejected) {
  const auto scene = TriangleScene();
  const Vec3 p{0.2f, 0.1f, 1.0f};
  std::string message;
  EXPECT_FALSE(SamplesFollowDensity(
      *scene, p, [&](Vec3 w) { return PdfByRay(*scene, p, w) * (w.x > 0.1f ? 1.1 : 0.9); }, &message));
  Moments m = Irradiance(*scene, p, {0, 0, 1}, 100000);
  EXPECT_FALSE(test::TTest(m, PolygonIrradiance(p, {0, 0, 1}, kTriangle, 3) * 1.02, kLevel).accepted);
}

TEST(TriangleLight, SolidAngleOfAnOctant) {
  SphericalTriangle octant;
  ASSERT_TRUE(LightTriangleLooms(
      {.p0 = {1, 0, 0}, .e1 = {-1, 1, 0}, .e2 = {-1, 0, 1}, .n = Normalize(Vec3{1, 1, 1}), .area = 0.866f}, {0, 0, 0},
      &octant));
  EXPECT_NEAR(octant.omega, kPi / 2, 1e-6);
}

TEST(SphereLight, OutsideInsideAndTiny) {
  SceneBuilder b;
  b.AddLight(SphereShape{0.5f}, Rgb(7), Transform::Translate({1, 2, 3}));
  const auto scene = b.Compile();
  const Vec3 c{1, 2, 3};
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 2, 2.4f}, Vec3{-20, 30, 3}}) {
    ExpectConsistent(*scene, p);
    const Vec3 n = Normalize(c - p);
    ExpectIrradiance(*scene, p, n, 7 * double(kPi) * 0.25 / LengthSquared(c - p));
  }
  EXPECT_FALSE(scene->SampleLight(c, 0.5f, {0.3f, 0.6f}));  // dark inside

  SceneBuilder inside;
  inside.AddLight(SphereShape{0.5f}, Rgb(7), Transform::Translate({1, 2, 3})).reverse_orientation = true;
  const auto cave = inside.Compile();
  ExpectConsistent(*cave, {1.2f, 2, 3.1f});
  ExpectIrradiance(*cave, {1, 2.1f, 3}, {0, 0, 1}, 7 * double(kPi));

  SceneBuilder tiny;  // 1e-7 sr
  tiny.AddLight(SphereShape{1.7841241e-4f}, Rgb(7), Transform::Translate({0, 0, 1}));
  const auto star = tiny.Compile();
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const auto s = star->SampleLight({0, 0, 0}, 0.5f, random.Next2D());
    ASSERT_TRUE(s);
    EXPECT_NEAR(s->pdf * 1e-7, 1, 1e-3);
  }
  ExpectIrradiance(*star, {0, 0, 0}, {0, 0, 1}, 7 * double(kPi) * 1.7841241e-4 * 1.7841241e-4, 2000);
}

TEST(SphereLight, StretchedToAnEllipsoid) {
  SceneBuilder b;
  b.AddLight(SphereShape{1}, Rgb(2), Transform::Translate({0, 0, 4}) * Transform::Scale({0.5f, 2, 1}));
  const auto scene = b.Compile();
  ExpectConsistent(*scene, {0, 0, 0});
  // Irradiance by brute force: uniform directions that hit.
  Random random(8);
  Moments brute;
  const Vec3 n{0, 0, 1};
  for (int i = 0; i < 400000; ++i) {
    const Vec3 w = SquareToCosineHemisphere(random.Next2D());
    Hit hit;
    brute.Add(scene->Intersect({{0, 0, 0}, w, kInfinity}, &hit) ? 2 * double(kPi) : 0.0);
  }
  const auto result = test::WelchTest(Irradiance(*scene, {0, 0, 0}, n, 200000), brute, kLevel);
  EXPECT_TRUE(result.accepted) << result.message;
}

TEST(DiskLight, CoaxialWithAndWithoutHole) {
  for (const float inner : {0.0f, 0.4f}) {
    SceneBuilder b;
    b.AddLight(DiskShape{1, inner, 0}, Rgb(5), Transform::Translate({0, 0, 1.5f}) * Transform::Rotate(180, {1, 0, 0}));
    const auto scene = b.Compile();
    const auto disk = [](double r) { return r * r / (r * r + 2.25); };
    ExpectIrradiance(*scene, {0, 0, 0}, {0, 0, 1}, 5 * double(kPi) * (disk(1) - disk(inner)));
    ExpectConsistent(*scene, {0.5f, 0.2f, 0});
    EXPECT_FALSE(scene->SampleLight({0, 0, 3}, 0.1f, {0.2f, 0.3f}));
  }
}

TEST(BilinearLight, TwistedPatch) {
  SceneBuilder b;
  BilinearMesh mesh;
  mesh.positions = {{-1, -1, 2}, {-1, 1, 2.5f}, {1, -1, 2.4f}, {1, 1, 2}};  // du x dv looks down
  mesh.patches = {{0, 1, 2, 3}};
  b.AddLight(mesh, Rgb(1));
  const auto scene = b.Compile();
  EXPECT_GT(scene->triangle_count(), 100u);
  Random random(8);
  Moments brute;
  for (int i = 0; i < 200000; ++i) {
    const Vec3 w = SquareToCosineHemisphere(random.Next2D());
    Hit hit;
    const Ray ray{{0, 0, 0}, w, kInfinity};
    brute.Add(scene->Intersect(ray, &hit) ? scene->Emitted(scene->Interaction(hit), -w).r * double(kPi) : 0.0);
  }
  EXPECT_GT(brute.mean(), 0.3);
  const auto result = test::WelchTest(Irradiance(*scene, {0, 0, 0}, {0, 0, 1}, 100000), brute, kLevel);
  EXPECT_TRUE(result.accepted) << result.message;
}

TEST(DeltaLights, MatchTheirFormulas) {
  SceneBuilder b;
  b.AddLight(PointLight{Rgb(6), {0, 0, 2}});
  ExpectIrradiance(*b.Compile(), {1, 0, 0}, {0, 0, 1}, 6.0 / 5 * 2 / std::sqrt(5.0), 10);

  SceneBuilder spot;
  spot.AddLight(SpotLight{Rgb(6), {0, 0, 2}, {0, 0, 0}, 40, 20});
  const auto s = spot.Compile();
  ExpectIrradiance(*s, {0, 0, 0}, {0, 0, 1}, 1.5, 10);
  EXPECT_FALSE(s->SampleLight({3, 0, 0}, 0.5f, {}));
  const double angle = 30 * M_PI / 180, x0 = std::cos(40 * M_PI / 180), x1 = std::cos(20 * M_PI / 180);
  const double t = (std::cos(angle) - x0) / (x1 - x0), step = t * t * (3 - 2 * t);
  const double distance = 2 / std::cos(angle);
  ExpectIrradiance(*s, {float(2 * std::tan(angle)), 0, 0}, {0, 0, 1},
                   6 * step * std::cos(angle) / (distance * distance), 10);

  SceneBuilder distant;
  distant.AddLight(DistantLight{Rgb(3), Normalize(Vec3{0, 1, 1})});
  ExpectIrradiance(*distant.Compile(), {1, 2, 3}, {0, 0, 1}, 3 * std::sqrt(0.5), 10);
  EXPECT_TRUE(distant.Compile()->needs().unseen_lights);
}

TEST(LightPower, ScalesTheWholeShape) {
  SceneBuilder b;
  auto& shape = b.AddLight(test::Quad({-1, -1, 2}, {0, 2, 0}, {2, 0, 0}), Rgb(1, 2, 3));
  shape.light->power = 100;
  const auto scene = b.Compile();
  const auto s = scene->SampleLight({0, 0, 0}, 0.3f, {0.4f, 0.4f});
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->radiance.r, 100 / (kPi * 4), 1e-4);  // pi * 4 m^2 of luminance 1, and the colour on top
  EXPECT_NEAR(s->radiance.b / s->radiance.r, 3, 1e-5);
}

// ---- environment ----

TEST(Octahedral, RoundTripsAndKeepsArea) {
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const Vec2 u = random.Next2D();
    const Vec3 w = OctahedralToDirection(u);
    EXPECT_NEAR(Length(w), 1, 1e-6);
    const Vec2 back = DirectionToOctahedral(w);
    EXPECT_NEAR(back.x, u.x, 2e-6);
    EXPECT_NEAR(back.y, u.y, 2e-6);
  }
  EXPECT_NEAR(OctahedralToDirection({0.5f, 0.5f}).z, 1, 1e-7);
  EXPECT_NEAR(OctahedralToDirection({1, 0.5f}).x, 1, 1e-6);
  EXPECT_NEAR(OctahedralToDirection({0.5f, 1}).y, 1, 1e-6);
  EXPECT_NEAR(OctahedralToDirection({0.999999f, 0.999999f}).z, -1, 1e-5);
  const auto result = test::ChiSquareOnSphere(
      [](Random& rng) { return std::optional(OctahedralToDirection(rng.Next2D())); },
      [](Vec3) { return double(kUniformSpherePdf); }, {.level = kLevel, .samples = 100000, .bins = 64});
  EXPECT_TRUE(result.accepted) << result.message;
}

TEST(EnvironmentLight, ConstantIrradiance) {
  SceneBuilder b;
  b.AddLight(InfiniteLight{Rgb(2), ""});
  const auto scene = b.Compile();
  ExpectIrradiance(*scene, {0, 0, 0}, {0, 0, 1}, 2 * double(kPi));
  EXPECT_EQ(scene->Environment({0, 1, 0}).pdf, kUniformSpherePdf);
  // Two of them are one strategy.
  b.AddLight(InfiniteLight{Rgb(3), ""});
  const auto both = b.Compile();
  EXPECT_EQ(both->Environment({0, 1, 0}).radiance.g, 5);
  EXPECT_NEAR(both->Environment({0, 1, 0}).pdf, kUniformSpherePdf, 1e-8);
  ExpectIrradiance(*both, {0, 0, 0}, {0, 0, 1}, 5 * double(kPi));
}

TEST(EnvironmentLight, DimSkyWithATinySun) {
  constexpr int kSize = 128;
  FloatImage image{kSize, kSize, std::vector<Rgb>(kSize * kSize)};
  for (int i = 0; i < kSize * kSize; ++i) image.pixels[i] = Rgb(0.1f + 0.05f * float(i % 7));
  image.At(70, 55) = Rgb(3e5f);  // 7.7e-4 sr
  const TemporaryFolder folder;
  const std::string path = folder / "tiny_sun.exr";
  WriteExr(path, image);
  SceneBuilder b;
  b.d.lights.push_back({InfiniteLight{Rgb(0.5f), path}, Transform::Rotate(35, {1, 2, 3}), {"test.pbrt", 1, 1}});
  const auto scene = b.Compile();

  // 1. Counts by texel against brightness above the mean, through the scene's own interface.
  const EnvironmentLight reference(image.pixels, kSize, Transform());
  const Transform light_from_world = Transform::Rotate(-35, {1, 2, 3});
  Random random(4);
  std::vector<double> observed(kSize * kSize), expected(kSize * kSize);
  constexpr int kSamples = 400000;
  int mismatches = 0;
  for (int i = 0; i < kSamples; ++i) {
    const auto s = scene->SampleLight({0, 0, 0}, 0.5f, random.Next2D());
    ASSERT_TRUE(s && s->infinite && s->pdf > 0);
    const auto seen = scene->Environment(s->wi);
    mismatches += std::fabs(seen.pdf / s->pdf - 1) > 1e-4f || std::fabs(seen.radiance.g / s->radiance.g - 1) > 1e-4f;
    const Vec2 square = DirectionToOctahedral(light_from_world.Vector(s->wi));
    observed[int(square.y * kSize) * kSize + int(square.x * kSize)] += 1;
  }
  EXPECT_LT(mismatches, kSamples / 1000);  // rounding at a texel's edge
  double mean = 0, total = 0;
  for (const Rgb& p : image.pixels) mean += double{p.g} / (kSize * kSize);
  for (const Rgb& p : image.pixels) total += std::max(p.g - mean, 0.0);
  for (size_t i = 0; i < expected.size(); ++i) {
    expected[i] = std::max(image.pixels[i].g - mean, 0.0) / total * kSamples;
  }
  // Pool into 16 x 16 blocks: texels beside the sun catch its rounding.
  std::vector<double> o(64), e(64);
  for (int i = 0; i < kSize * kSize; ++i) {
    const int block = (i / kSize / 16) * 8 + (i % kSize) / 16;
    o[block] += observed[i];
    e[block] += expected[i];
  }
  const auto chi = test::ChiSquareTest(o, e, kLevel);
  EXPECT_TRUE(chi.accepted) << chi.message;

  // 2. Irradiance against a sum over the texels (the sun is at least 30 degrees above this horizon).
  const Vec3 n = Transform::Rotate(35, {1, 2, 3}).Vector(OctahedralToDirection({70.5f / kSize, 55.5f / kSize}));
  double irradiance = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (int sub = 0; sub < 16; ++sub) {
        const Vec3 w = Transform::Rotate(35, {1, 2, 3})
                           .Vector(OctahedralToDirection(
                               {(x + (sub % 4 + 0.5f) / 4) / kSize, (y + (sub / 4 + 0.5f) / 4) / kSize}));
        irradiance += std::max(0.0f, Dot(n, w)) * 0.5 * image.At(x, y).g * 4 * double(kPi) / (kSize * kSize * 16.0);
      }
  const auto t = test::TTest(Irradiance(*scene, {0, 0, 0}, n, 200000), irradiance, kLevel, 1e-4 * irradiance);
  EXPECT_TRUE(t.accepted) << t.message;
  EXPECT_EQ(reference.Evaluate({0, 0, 1}).radiance, image.At(64, 64));
}

TEST(EnvironmentLight, IlluminanceOfAnImage) {
  constexpr int kSize = 64;
  FloatImage image{kSize, kSize, std::vector<Rgb>(kSize * kSize)};
  for (int i = 0; i < kSize * kSize; ++i) image.pixels[i] = Rgb(0.1f + 0.3f * float(i % 5));
  const TemporaryFolder folder;
  const std::string path = folder / "illuminance.exr";
  WriteExr(path, image);
  const Transform turned = Transform::Rotate(50, {1, -2, 1});
  const auto compile = [&](float scale, float illuminance) {
    SceneBuilder b;
    b.d.lights.push_back({InfiniteLight{Rgb(scale), path, illuminance}, turned, {"test.pbrt", 5, 1}});
    return b.Compile();
  };
  ExpectIrradiance(*compile(1, 10), {0, 0, 0}, Normalize(turned.Vector({0, 0, 1})), 10);
  ExpectIrradiance(*compile(2, 10), {0, 0, 0}, Normalize(turned.Vector({0, 0, 1})), 20);
  // An even image is a constant light: pi for a radiance of 1.
  EXPECT_NEAR(IrradianceFromAbove(std::vector<Rgb>(kSize * kSize, Rgb(1)), kSize).g, kPi, 1e-3);
  // Light from below alone.
  for (int i = 0; i < kSize * kSize; ++i) {
    const Vec2 at{(float(i % kSize) + 0.5f) / kSize, (float(i / kSize) + 0.5f) / kSize};
    if (OctahedralToDirection(at).z > -0.1f) image.pixels[i] = Rgb(0);
  }
  WriteExr(path, image);
  try {
    compile(1, 10);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("test.pbrt:5:1"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("needs light from above"), std::string::npos) << error.what();
  }
}

TEST(EnvironmentLight, TexelsAreSampledByWhatExceedsTheMean) {
  constexpr int kSize = 24;
  std::vector<Rgb> pixels;
  double mean = 0;
  for (int i = 0; i < kSize * kSize; ++i) {
    pixels.push_back(Rgb(0.2f + static_cast<float>(i * 7 % 11), 1, static_cast<float>(i / kSize % 5)));
    mean += (double{pixels[i].r} + pixels[i].g + pixels[i].b) / 3 / (kSize * kSize);
  }
  const EnvironmentLight light(pixels, kSize, Transform());
  EXPECT_NEAR((light.mean().r + light.mean().g + light.mean().b) / 3, mean, 1e-5);
  Random random(9);
  constexpr int kSamples = 200000;
  std::vector<double> observed(kSize * kSize), expected(kSize * kSize);
  double total = 0;
  for (int i = 0; i < kSamples; ++i) {
    EnvironmentLight::Value value;
    const Vec2 square = DirectionToOctahedral(light.Sample(random.Next2D(), &value));
    ASSERT_GT(value.pdf, 0);
    observed[static_cast<int>(square.y * kSize) * kSize + static_cast<int>(square.x * kSize)] += 1;
  }
  for (int i = 0; i < kSize * kSize; ++i) {
    const auto value = light.Evaluate(OctahedralToDirection(
        {(static_cast<float>(i % kSize) + 0.5f) / kSize, (static_cast<float>(i / kSize) + 0.5f) / kSize}));
    EXPECT_EQ(value.radiance, pixels[i]);
    EXPECT_EQ(value.pdf > 0, (double{pixels[i].r} + pixels[i].g + pixels[i].b) / 3 > mean);
    expected[i] = double{value.pdf} / kUniformSpherePdf / (kSize * kSize) * kSamples;
    total += expected[i];
  }
  EXPECT_NEAR(total, kSamples, 1e-5 * kSamples);
  const auto chi = test::ChiSquareTest(observed, expected, kLevel);
  EXPECT_TRUE(chi.accepted) << chi.message;
  expected[0] += kSamples * 0.01;
  EXPECT_FALSE(test::ChiSquareTest(observed, expected, kLevel).accepted);
  // Nothing exceeds the mean of an even one: it is sampled evenly.
  const EnvironmentLight even(std::vector<Rgb>(kSize * kSize, Rgb(0.3f)), kSize, Transform());
  EXPECT_NEAR(even.Evaluate({0, 0, 1}).pdf, kUniformSpherePdf, 1e-6);
}

}  // namespace
}  // namespace lodestar
