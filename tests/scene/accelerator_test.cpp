#include "core/scene/accelerator.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/base/error.h"
#include "tests/scene/scene_builder.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using test::Random;
using test::SceneBuilder;

Vec3 RandomVector(Random& random) {
  const Vec2 u = random.Next2D();
  return {2 * u.x - 1, 2 * u.y - 1, 2 * random.Next1D() - 1};
}

// Many triangles, each three times in the same place.
SceneBuilder Duplicates() {
  SceneBuilder b;
  Random random(11);
  TriangleMesh mesh;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 center = RandomVector(random);
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(center + RandomVector(random) * 0.05f);
    const auto base = uint32_t(3 * i);
    for (int copy = 0; copy < 3; ++copy) mesh.triangles.push_back({base, base + 1, base + 2});
  }
  b.Add(mesh);
  b.Add(mesh);
  return b;
}

std::vector<Hit> Trace(const Scene& scene, int rays) {
  Random random(12);
  std::vector<Hit> hits;
  for (int i = 0; i < rays; ++i) {
    Hit hit{};
    const Vec3 origin = RandomVector(random) * 1.5f;
    if (!scene.Intersect({origin, Normalize(RandomVector(random)), kInfinity}, &hit)) hit.primitive = ~0u;
    hits.push_back(hit);
  }
  return hits;
}

// The hits, primitive ids among coplanar duplicates included, do not depend on the threads that were there when the
// tree was built.
TEST(Accelerator, BuildsTheSameTreeInAnyArena) {
  const SceneBuilder b = Duplicates();
  const auto first = Trace(*b.Compile(), 20000);
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena arena(threads);
    std::shared_ptr<const Scene> scene;
    arena.execute([&] {
      tbb::parallel_for(0, 4, [&](int i) {
        if (i == 2) scene = b.Compile();
      });
    });
    const auto again = Trace(*scene, 20000);
    int hits = 0;
    for (size_t i = 0; i < first.size(); ++i) {
      ASSERT_EQ(first[i].primitive, again[i].primitive);
      if (first[i].primitive == ~0u) continue;
      ++hits;
      ASSERT_EQ(first[i].t, again[i].t);
      ASSERT_EQ(first[i].u, again[i].u);
    }
    EXPECT_GT(hits, 5000);
  }
}

struct Extreme {
  float scale;
  float away;  // of the origin, in world units
};
class AcceleratorExtremes : public testing::TestWithParam<Extreme> {};

// Rays that leave a convex surface outwards meet nothing; inside a closed thin box everything is met.
TEST_P(AcceleratorExtremes, OffsetsNeitherSelfIntersectNorLeak) {
  const auto [scale, away] = GetParam();
  const Vec3 shift{away, -0.7f * away, 0.3f * away};
  SceneBuilder b;
  b.Add(test::Box(shift + Vec3{-1, -1, -1} * scale, shift + Vec3{1, 1, 1} * scale));
  const auto box = b.Compile();
  SceneBuilder thin;  // a hundredth thin
  const Transform tilt =
      Transform::Translate(shift) * Transform::Rotate(33, {1, 2, 3}) * Transform::Scale({scale, scale, scale});
  thin.Add(test::Box({-1, -1, -0.005f}, {1, 1, 0.005f}), tilt);
  const auto slab = thin.Compile();
  Random random(7);
  int self = 0, rays = 0, leaks = 0;
  for (int i = 0; i < 100000; ++i) {
    Hit hit;
    const Ray ray = test::Towards(shift + Normalize(RandomVector(random)) * (4 * scale),
                                  shift + RandomVector(random) * (0.9f * scale));
    if (!box->Intersect(ray, &hit)) continue;
    const auto si = box->Interaction(hit);
    EXPECT_GT(Dot(si.ng, -ray.direction), 0);
    Vec3 w = Normalize(RandomVector(random));
    if (Dot(w, si.ng) < 0) w = -w;
    ++rays;
    self += box->Intersect({Scene::OffsetOrigin(si, w), w, kInfinity}, &hit);
  }
  EXPECT_GT(rays, 50000);
  EXPECT_EQ(self, 0);
  for (int i = 0; i < 200; ++i) {
    Ray ray{shift, Normalize(RandomVector(random)), kInfinity};
    for (int bounce = 0; bounce < 200; ++bounce) {
      Hit hit;
      if (!slab->Intersect(ray, &hit)) {
        ++leaks;
        break;
      }
      const auto si = slab->Interaction(hit);
      Vec3 w = Normalize(RandomVector(random));
      if (Dot(w, si.ng) > 0) w = -w;  // stay inside
      ray = {Scene::OffsetOrigin(si, w), w, kInfinity};
    }
  }
  // Far from the origin the floats next to a point at the slab's edge lie outside it: then, and only then, a few
  // escape.
  EXPECT_LE(leaks, away > 0 ? 4 : 0) << "of 40000 bounces";
}

TEST_P(AcceleratorExtremes, SpheresAndDisksHoldToo) {
  const auto [scale, away] = GetParam();
  const Vec3 shift{away, -0.7f * away, 0.3f * away};
  SceneBuilder b;
  b.Add(SphereShape{scale}, Transform::Translate(shift));
  const auto scene = b.Compile();
  SceneBuilder d;
  d.Add(DiskShape{scale, 0, 0}, Transform::Translate(shift) * Transform::Rotate(40, {3, 1, 1}));
  const auto disk = d.Compile();
  Random random(9);
  int rays = 0, self = 0, leaks = 0, disk_self = 0, disk_rays = 0;
  for (int i = 0; i < 50000; ++i) {
    Hit hit;
    const Ray ray = test::Towards(shift + Normalize(RandomVector(random)) * (4 * scale),
                                  shift + RandomVector(random) * (0.5f * scale));
    Vec3 w = Normalize(RandomVector(random));
    if (disk->Intersect(ray, &hit)) {
      const auto si = disk->Interaction(hit);
      ++disk_rays;
      disk_self += disk->Intersect({Scene::OffsetOrigin(si, w), w, kInfinity}, &hit);
    }
    if (!scene->Intersect(ray, &hit)) continue;
    const auto si = scene->Interaction(hit);
    ++rays;
    const float error = std::fabs(Length(si.p - shift) - scale);
    EXPECT_LE(error, si.offset);
    const bool outwards = Dot(w, si.ng) > 0;
    const bool met = scene->Intersect({Scene::OffsetOrigin(si, w), w, kInfinity}, &hit);
    (outwards ? self : leaks) += outwards ? met : !met;
  }
  EXPECT_GT(rays, 40000);
  EXPECT_EQ(self, 0);
  EXPECT_LE(leaks, rays / 5000);  // rays along the surface start outside the curve
  EXPECT_GT(disk_rays, 5000);
  EXPECT_EQ(disk_self, 0);
}

INSTANTIATE_TEST_SUITE_P(Scales, AcceleratorExtremes,
                         testing::Values(Extreme{1, 0}, Extreme{1e-4f, 0}, Extreme{1e7f, 0}, Extreme{1e3f, 1e6f},
                                         Extreme{300, 1e6f}, Extreme{1, 100}));

TEST(Accelerator, SliversDoNotHitThemselves) {
  SceneBuilder b;
  TriangleMesh mesh;
  Random random(21);
  for (int i = 0; i < 300; ++i) {  // far apart, so that only the own triangle can be met
    const Vec3 base{float(i) * 100, 0, 0};
    const Vec3 along = Normalize(RandomVector(random)), across = Normalize(Cross(along, RandomVector(random)));
    const float thin = Pow(10, -3 * random.Next1D());
    mesh.positions.insert(mesh.positions.end(), {base, base + along, base + along * random.Next1D() + across * thin});
    mesh.triangles.push_back({uint32_t(3 * i), uint32_t(3 * i + 1), uint32_t(3 * i + 2)});
  }
  b.Add(mesh);
  const auto scene = b.Compile();
  int rays = 0, self = 0;
  for (int i = 0; i < 100000; ++i) {
    const size_t k = 3 * (random.Next() % 300);
    const Vec2 u = SquareToTriangle(random.Next2D());
    const Vec3 target = mesh.positions[k] * (1 - u.x - u.y) + mesh.positions[k + 1] * u.x + mesh.positions[k + 2] * u.y;
    const Ray ray = test::Towards(target + RandomVector(random) * 3, target);
    Hit hit;
    if (!scene->Intersect(ray, &hit)) continue;
    const auto si = scene->Interaction(hit);
    const Vec3 w = Normalize(RandomVector(random));
    ++rays;
    Hit again;
    self += scene->Intersect({Scene::OffsetOrigin(si, w), w, 5}, &again) && again.primitive == hit.primitive;
  }
  EXPECT_GT(rays, 80000);
  EXPECT_EQ(self, 0);
}

TEST(Accelerator, ATinySphereFarAwayIsMet) {
  SceneBuilder b;
  b.Add(SphereShape{1e-4f});
  const auto scene = b.Compile();
  int met = 0;
  for (int i = 0; i < 100; ++i) {
    const float y = (float(i) / 99 - 0.5f) * 4e-4f;
    Hit hit;
    met += scene->Intersect({{1e7f, y, 0}, {-1, 0, 0}, kInfinity}, &hit);
  }
  EXPECT_NEAR(met, 50, 2);
}

TEST(Accelerator, ConstantAlphaIsAStochasticOpacity) {
  SceneBuilder b;
  b.Add(test::Quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})).alpha.value = 0.3f;
  const auto scene = b.Compile();
  EXPECT_TRUE(scene->needs().alpha);
  Random random(3);
  int met = 0, blocked = 0;
  constexpr int kRays = 100000;
  for (int i = 0; i < kRays; ++i) {
    const Vec2 u = random.Next2D();
    const Ray ray{{u.x - 0.5f, u.y - 0.5f, 1}, {0, 0, -1}, kInfinity};
    Hit hit;
    const bool a = scene->Intersect(ray, &hit), again = scene->Intersect(ray, &hit);
    EXPECT_EQ(a, again);                    // a pure function
    EXPECT_EQ(a, !scene->Unoccluded(ray));  // and the same for both kinds of rays
    met += a;
    blocked += !scene->Unoccluded(ray);
  }
  EXPECT_NEAR(met / double(kRays), 0.3, 0.006);
  EXPECT_EQ(met, blocked);

  for (const float alpha : {0.0f, 1.0f}) {
    SceneBuilder constant;
    constant.Add(test::Quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})).alpha.value = alpha;
    const auto s = constant.Compile();
    Hit hit;
    EXPECT_FALSE(s->needs().alpha);
    EXPECT_EQ(s->Intersect({{0.1f, 0.2f, 1}, {0, 0, -1}, kInfinity}, &hit), alpha == 1);
  }
}

// How far rays down the z axis from 4 above go, by whole units; the last count is of those that meet nothing. Both
// kinds of rays agree on that.
std::vector<double> Depths(const Scene& scene, int rays) {
  Random random(17);
  std::vector<double> counts(9);
  for (int i = 0; i < rays; ++i) {
    const Vec2 u = random.Next2D();
    const Ray ray{{0.1f * u.x, 0.1f * u.y, 4}, {0, 0, -1}, kInfinity};
    Hit hit;
    const bool met = scene.Intersect(ray, &hit);
    EXPECT_EQ(met, !scene.Unoccluded(ray));
    ++counts[met ? static_cast<size_t>(hit.t + 0.5f) : 8];
  }
  return counts;
}

// Each layer on a ray's way takes its share of what the layers before it let through.
TEST(Accelerator, LayersOfAlphaDecideEachOnItsOwn) {
  constexpr int kRays = 100000;
  const double level = test::SidakLevel(0.01, 2);
  SceneBuilder ball;
  ball.Add(SphereShape{1}).alpha.value = 0.5f;
  // Two objects and the world, each with one shape that is the first of its kind. An object used once would be the
  // world's.
  SceneBuilder quads;
  for (const float z : {1.0f, 0.0f, -1.0f}) quads.Add(test::Quad({-1, -1, z}, {2, 0, 0}, {0, 2, 0})).alpha.value = 0.5f;
  for (const int object : {0, 1}) {
    quads.d.objects.push_back({"o", {quads.d.shapes.front()}});
    for (const float x : {0.0f, 5.0f}) quads.d.instances.push_back({object, Transform::Translate({x, 0, 0}), {}});
    quads.d.shapes.erase(quads.d.shapes.begin());
  }
  const auto expect = [&](const SceneBuilder& b, std::vector<double> shares, std::vector<double> as_one) {
    const auto counts = Depths(*b.Compile(), kRays);
    for (auto* v : {&shares, &as_one})
      for (double& share : *v) share *= kRays;
    const auto result = test::ChiSquareTest(counts, shares, level);
    EXPECT_TRUE(result.accepted) << result.message;
    EXPECT_FALSE(test::ChiSquareTest(counts, as_one, level).accepted);
  };
  // Near wall, far wall, neither.
  expect(ball, {0, 0, 0, 0.5, 0, 0.25, 0, 0, 0.25}, {0, 0, 0, 0.5, 0, 0, 0, 0, 0.5});
  expect(quads, {0, 0, 0, 0.5, 0.25, 0.125, 0, 0, 0.125}, {0, 0, 0, 0.5, 0, 0, 0, 0, 0.5});
}

TEST(Accelerator, InterfacesAreNotThere) {
  SceneBuilder b;
  b.d.materials.push_back({"nothing", InterfaceMaterial{}, {}});
  b.d.materials.push_back({"nothing twice", MixMaterial{1, 1, {0.3f}}, {}});
  b.Add(test::Quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})).material = 1;
  b.Add(test::Quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0})).material = 2;
  const auto scene = b.Compile();
  const Ray ray{{0.1f, 0.2f, 1}, {0, 0, -1}, kInfinity};
  EXPECT_TRUE(scene->Unoccluded(ray));
  Hit hit;
  EXPECT_FALSE(scene->Intersect(ray, &hit));
  EXPECT_FALSE(scene->needs().alpha);
  b.AddLight(test::Quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}), Rgb(1)).material = 1;
  EXPECT_THROW(b.Compile(), Error);  // nothing to give light
}

// Each sheet decides for itself, for paths and shadow rays alike, and what is met is never the interface.
TEST(Accelerator, InterfacesInAMixAreOpacity) {
  SceneBuilder b;
  const auto add = [&](MaterialDescription m) {
    b.d.materials.push_back(std::move(m));
    return static_cast<int>(b.d.materials.size()) - 1;
  };
  const int nothing = add({"nothing", InterfaceMaterial{}, {}});
  const int mirror = add({"mirror", ConductorMaterial{}, {}});
  const int gauze = add({"gauze", MixMaterial{nothing, mirror, {0.3f}}, {}});  // 0.3 opaque
  const int veil = add({"veil", MixMaterial{gauze, nothing, {0.5f}}, {}});     // 0.15
  const int leaf = add({"leaf", MixMaterial{0, veil, {0.8f}}, {}});            // 0.2 + 0.8 * 0.15 = 0.32
  for (const auto& [z, material] : {std::pair{0.0f, gauze}, {-1.0f, leaf}})
    b.Add(test::Quad({-1, -1, z}, {2, 0, 0}, {0, 2, 0})).material = material;
  const auto scene = b.Compile();
  EXPECT_TRUE(scene->needs().alpha);
  constexpr int kRays = 40000;
  int passed = 0, unoccluded = 0, met[2] = {}, mirrors = 0;
  test::Random random(5);
  for (int i = 0; i < kRays; ++i) {
    const Vec2 u = random.Next2D(), v = random.Next2D();
    const Ray ray{{u.x - 0.5f, u.y - 0.5f, 1}, Normalize({0.1f * v.x, 0.1f * v.y, -1}), kInfinity};
    unoccluded += scene->Unoccluded(ray);
    Hit hit;
    if (!scene->Intersect(ray, &hit)) {
      ++passed;
      continue;
    }
    const SurfaceInteraction si = scene->Interaction(hit);
    ++met[si.p.z < -0.5f];
    const Bsdf bsdf = scene->BsdfAt(si, random.Next2D().x);
    ASSERT_NE(bsdf.kind(), Bsdf::Kind::kNone);
    mirrors += si.p.z < -0.5f && bsdf.kind() != Bsdf::Kind::kDiffuse;
  }
  const auto near = [](int count, double n, double p) {
    return std::fabs(count - n * p) < 4 * std::sqrt(n * p * (1 - p));
  };
  EXPECT_EQ(passed, unoccluded);
  EXPECT_TRUE(near(met[0], kRays, 0.3)) << met[0];
  EXPECT_TRUE(near(passed, kRays, 0.7 * 0.68)) << passed;
  EXPECT_TRUE(near(mirrors, met[1], 0.12 / 0.32)) << mirrors << " of " << met[1];
}

}  // namespace
}  // namespace lodestar
