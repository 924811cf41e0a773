#include "core/scene/scene.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "core/base/error.h"
#include "core/image/image.h"
#include "tests/scene/scene_builder.h"
#include "tests/support/statistical.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using test::Random;
using test::SceneBuilder;

SurfaceInteraction At(const Scene& scene, const Ray& ray) {
  Hit hit;
  EXPECT_TRUE(scene.Intersect(ray, &hit));
  return scene.Interaction(hit);
}
const Ray kDown{{0.25f, 0.25f, 5}, {0, 0, -1}, kInfinity};

TriangleMesh Flat() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TEST(Interaction, NormalsFollowWindingReversalAndMirrors) {
  const Transform mirror = Transform::Scale({1, 1, -1});
  for (const bool reverse : {false, true})
    for (const bool mirrored : {false, true}) {
      SceneBuilder b;
      b.Add(Flat(), mirrored ? mirror : Transform()).reverse_orientation = reverse;
      // The mirror in the triangle's own plane leaves its winding; its normal (0, 0, 1) maps to (0, 0, -1).
      const float expected = (reverse ? -1.0f : 1.0f) * (mirrored ? -1.0f : 1.0f);
      EXPECT_EQ(At(*b.Compile(), kDown).ng.z, expected) << reverse << mirrored;
      // Vertex normals rule where they are given; ReverseOrientation turns them, a mirror maps them.
      TriangleMesh smooth = Flat();
      smooth.normals.assign(3, Normalize(Vec3{0.2f, 0, -1}));
      SceneBuilder n;
      n.Add(smooth, mirrored ? mirror : Transform()).reverse_orientation = reverse;
      const auto si = At(*n.Compile(), kDown);
      EXPECT_EQ(si.ng.z, -expected);
      EXPECT_GT(Dot(si.ng, si.shading.n), 0.9f);
      EXPECT_LT(Dot(si.ng, si.shading.n), 0.99f);
    }
}

TEST(Interaction, ZeroAndNanNormalsFallBackToTheGeometricOne) {
  for (const Vec3 bad : {Vec3{0, 0, 0}, Vec3{NAN, 0, 1}}) {
    TriangleMesh mesh = Flat();
    mesh.normals.assign(3, bad);
    SceneBuilder b;
    b.Add(mesh);
    const auto si = At(*b.Compile(), kDown);
    EXPECT_EQ(si.ng, (Vec3{0, 0, 1}));
    EXPECT_EQ(si.shading.n, si.ng);
  }
}

TEST(Interaction, TangentsFollowU) {
  SceneBuilder b;
  b.d.materials[0].kind = ConductorMaterial{{Rgb(1)}, {Rgb(2)}, false, {}, {{0.1f}, {0.4f}, false}};
  TriangleMesh mesh = Flat();
  mesh.uvs = {{0, 0}, {0, 1}, {1, 0}};  // u runs along y
  b.Add(mesh);
  const auto si = At(*b.Compile(), kDown);
  EXPECT_NEAR(si.shading.s.y, 1, 1e-6);
  EXPECT_NEAR(Dot(Cross(si.shading.s, si.shading.t), si.shading.n), 1, 1e-6);
}

TEST(Interaction, DefaultUvs) {
  SceneBuilder b;
  b.d.textures.push_back({"t", false, CheckerboardTexture{}, {}});
  b.d.materials[0].kind = DiffuseMaterial{{Rgb(), 0}};
  b.Add(Flat());
  const auto si = At(*b.Compile(), {{0.5f, 0.2f, 5}, {0, 0, -1}, kInfinity});
  EXPECT_NEAR(si.uv.x, 0.7, 1e-6);  // corners (0,0), (1,0), (1,1)
  EXPECT_NEAR(si.uv.y, 0.2, 1e-6);
  SceneBuilder s;
  s.d = b.d;
  s.d.shapes.clear();
  s.Add(SphereShape{2});
  const auto sphere = At(*s.Compile(), {{0, -9, 0}, {0, 1, 0}, kInfinity});
  EXPECT_NEAR(sphere.uv.x, 0.75, 1e-6);
  EXPECT_NEAR(sphere.uv.y, 0.5, 1e-6);
  EXPECT_NEAR(sphere.ng.y, -1, 1e-6);
  SceneBuilder d;
  d.d = s.d;
  d.d.shapes.clear();
  d.Add(DiskShape{2, 1, 0});
  const auto disk = At(*d.Compile(), {{0, 1.5f, 3}, {0, 0, -1}, kInfinity});
  EXPECT_NEAR(disk.uv.x, 0.25, 1e-6);
  EXPECT_NEAR(disk.uv.y, 0.5, 1e-6);
  EXPECT_EQ(disk.ng.z, 1);
}

TEST(Scene, DegenerateTrianglesAreDroppedAndCounted) {
  SceneBuilder b;
  TriangleMesh mesh = Flat();
  mesh.positions.push_back({2, 0, 0});
  mesh.triangles.push_back({0, 1, 3});  // a line
  mesh.triangles.push_back({0, 0, 2});
  b.Add(mesh);
  const auto scene = b.Compile();
  EXPECT_EQ(scene->triangle_count(), 1u);
  EXPECT_EQ(scene->dropped_triangles(), 2u);
}

TEST(Scene, BadGeometryIsRefusedWithItsPlace) {
  const auto expect = [](const std::function<void(SceneBuilder&)>& spoil, ErrorKind kind) {
    SceneBuilder b;
    b.Add(Flat());
    spoil(b);
    try {
      b.Compile();
      ADD_FAILURE();
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), kind) << e.what();
      EXPECT_NE(std::string(e.what()).find("test.pbrt:"), std::string::npos) << e.what();
    }
  };
  const auto mesh = [](SceneBuilder& b) -> TriangleMesh& { return std::get<TriangleMesh>(b.d.shapes[0].kind); };
  expect([&](SceneBuilder& b) { mesh(b).positions[1].x = NAN; }, ErrorKind::kInvalidInput);
  expect([&](SceneBuilder& b) { mesh(b).positions[1].x = 1e20f; }, ErrorKind::kInvalidInput);
  expect([&](SceneBuilder& b) { mesh(b).triangles[0][2] = 3; }, ErrorKind::kInvalidInput);
  expect([&](SceneBuilder& b) { mesh(b).uvs.resize(2); }, ErrorKind::kInvalidInput);
  expect(
      [&](SceneBuilder& b) {
        b.d.shapes[0].world_from_object = Transform::Scale({1, 0, 1});
      },
      ErrorKind::kInvalidInput);
  expect(
      [&](SceneBuilder& b) {
        b.AddLight(Flat(), Rgb(NAN)), b.d.shapes.back().light->where = {"test.pbrt", 1, 1};
      },
      ErrorKind::kInvalidInput);
  expect([&](SceneBuilder& b) { b.AddLight(InfiniteLight{Rgb(1), "/absent.exr"}); }, ErrorKind::kNotFound);
  expect(
      [&](SceneBuilder& b) {
        b.AddLight(Flat(), Rgb(1));
        b.d.objects.push_back({"o", {b.d.shapes.back()}});
        b.d.shapes.pop_back();
        b.d.instances.push_back({0, Transform(), {}});
      },
      ErrorKind::kUnsupported);
}

// ---- instances ----

TEST(Instances, EqualFlattenedGeometry) {
  Random random(5);
  TriangleMesh blob;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 3; ++k) {
      blob.positions.push_back({random.Next1D(), random.Next1D(), random.Next1D()});
      blob.normals.push_back(Normalize(Vec3{random.Next1D() - 0.5f, random.Next1D() - 0.5f, random.Next1D() - 0.5f}));
    }
  for (uint32_t i = 0; i < 60; ++i) blob.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  const std::vector<Transform> places{Transform::Translate({2, 0, 1}) * Transform::Rotate(50, {1, 1, 0}),
                                      Transform::Translate({-1, 3, 0}) * Transform::Scale({-2, 1, 0.5f}),
                                      Transform::Rotate(120, {0, 1, 3}) * Transform::Translate({0, -4, 0})};
  SceneBuilder instanced, flat;
  ShapeDescription shape = instanced.Add(blob, Transform::Rotate(20, {1, 0, 0}));
  ShapeDescription ball = instanced.Add(SphereShape{0.4f}, Transform::Translate({0.5f, 0.5f, 1.2f}));
  instanced.d.shapes.clear();
  shape.reverse_orientation = true;
  instanced.d.objects.push_back({"blob", {shape, ball}});
  for (const auto& place : places) {
    instanced.d.instances.push_back({0, place, {}});
    for (const auto& s : {shape, ball}) {
      flat.d.shapes.push_back(s);
      flat.d.shapes.back().world_from_object = place * s.world_from_object;
    }
  }
  const auto a = instanced.Compile(), b = flat.Compile();
  EXPECT_TRUE(a->needs().instances);
  EXPECT_FALSE(b->needs().instances);
  EXPECT_NE(a->hash(), b->hash());
  int hits = 0, odd = 0;
  for (int i = 0; i < 80000; ++i) {
    const Vec3 origin{random.Next1D() * 12 - 6, random.Next1D() * 12 - 6, random.Next1D() * 12 - 6};
    const Ray ray = test::Towards(origin, {random.Next1D() * 4 - 2, random.Next1D() * 6 - 2, random.Next1D() * 3});
    Hit ha, hb;
    const bool ma = a->Intersect(ray, &ha), mb = b->Intersect(ray, &hb);
    if (ma != mb || (ma && std::fabs(ha.t - hb.t) > 1e-4f)) {
      ++odd;  // an edge
      continue;
    }
    EXPECT_EQ(a->Unoccluded(ray), !ma);
    if (!ma) continue;
    ++hits;
    const auto sa = a->Interaction(ha), sb = b->Interaction(hb);
    ASSERT_LE(Length(sa.p - sb.p), 2e-5f);
    ASSERT_GT(Dot(sa.ng, sb.ng), 0.999f);
    ASSERT_GT(Dot(sa.shading.n, sb.shading.n), 0.999f);
    Hit again;
    const Vec3 away = Dot(ray.direction, sa.ng) > 0 ? sa.ng : -sa.ng;
    const bool met = a->Intersect({Scene::OffsetOrigin(sa, away), away, kInfinity}, &again);
    EXPECT_FALSE(met && ha.geometry == 0 && again.geometry == 0 && again.primitive == ha.primitive &&
                 again.instance == ha.instance);
  }
  EXPECT_GT(hits, 3000);
  EXPECT_LT(odd, 40);
}

// ---- reach ----

// A ground of this half side, at `place`, in the world, or in an object that is used once or twice.
SceneBuilder Ground(float half, Vec3 place, int uses) {
  SceneBuilder b;
  b.Add(test::Quad({-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0}), Transform::Translate(place));
  if (uses > 0) {
    b.d.objects.push_back({"o", {b.d.shapes[0]}});
    b.d.shapes.clear();
    for (int i = 0; i < uses; ++i) b.d.instances.push_back({0, Transform(), {"test.pbrt", 20, 1}});
  }
  return b;
}

// What reaches too far for its normal to be computed is an error; what does not is there.
TEST(Reach, GeometryIsMetOrRefusedAndNeverDropped) {
  for (const int uses : {0, 1, 2}) {
    for (const float half : {1.0f, 1e6f, 0.99e9f}) {
      const auto scene = Ground(half, {}, uses).Compile();
      EXPECT_EQ(scene->dropped_triangles(), 0u);
      EXPECT_NEAR(At(*scene, kDown).ng.z, 1, 1e-6) << half;
    }
    for (const float half : {1.1e9f, 5e9f, 1e10f, 1e14f}) EXPECT_THROW(Ground(half, {}, uses).Compile(), Error) << half;
    EXPECT_THROW(Ground(1, {0, 0, 2e9f}, uses).Compile(), Error);
  }
  // Only the instance reaches too far.
  SceneBuilder far = Ground(1, {}, 2);
  far.d.instances[1].world_from_instance = Transform::Translate({2e9f, 0, 0});
  SceneBuilder ball;
  ball.Add(SphereShape{1.1e9f});
  for (const SceneBuilder& b : {far, ball}) {
    try {
      b.Compile();
      ADD_FAILURE() << "was accepted";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("beyond 1e9"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("test.pbrt:"), std::string::npos) << error.what();
    }
  }
}

// The largest triangles that may shine do so as they should: seen from a little above, half of the sky.
TEST(Reach, AnEmitterOfTheLargestSizeLights) {
  SceneBuilder b;
  b.AddLight(test::Quad({-1e9f, -1e9f, 0}, {2e9f, 0, 0}, {0, 2e9f, 0}), Rgb(1));
  const auto scene = b.Compile();
  Random random(4);
  test::Moments irradiance;
  for (int i = 0; i < 20000; ++i) {
    const Vec2 u = random.Next2D();
    const auto s = scene->SampleLight({0, 0, 1e7f}, random.Next1D(), u);
    irradiance.Add(s ? std::max(-s->wi.z, 0.0f) / double(s->pdf) : 0);
  }
  const auto result = test::TTest(irradiance, double(kPi), 0.01, 1e-3);
  EXPECT_TRUE(result.accepted) << result.message;
  EXPECT_FALSE(test::TTest(irradiance, 1.05 * double(kPi), 0.01, 1e-3).accepted);
}

TEST(Instances, UsedOnceJoinsTheWorld) {
  SceneBuilder b;
  b.Add(Flat());
  b.d.objects.push_back({"o", {b.d.shapes[0]}});
  b.d.shapes.clear();
  b.d.instances.push_back({0, Transform::Translate({0, 0, 2}), {}});
  const auto scene = b.Compile();
  EXPECT_FALSE(scene->needs().instances);
  EXPECT_NEAR(At(*scene, kDown).p.z, 2, 1e-6);
  b.d.instances[0].object = 4;
  EXPECT_THROW(b.Compile(), Error);
}

TEST(Environment, AnImageThatIsNotSquareIsRefusedByName) {
  TemporaryFolder folder;
  SceneBuilder b;
  b.Add(Flat());
  const std::string path = folder.Write("sky.ppm", "P3 2 1 255\n1 2 3 4 5 6\n");
  b.AddLight(InfiniteLight{.radiance = Rgb(1), .path = path});
  try {
    b.Compile();
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
    EXPECT_EQ(std::string(error.what()).rfind("test.pbrt:5:1: environment image '" + path + "' is 2 x 1", 0), 0u)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("makeequiarea"), std::string::npos) << error.what();
  }
}

TEST(Bilinear, ParallelogramIsTwoTrianglesAndFacesItsCrossProduct) {
  SceneBuilder b;
  BilinearMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.patches = {{0, 1, 2, 3}};
  b.Add(mesh);
  const auto scene = b.Compile();
  EXPECT_EQ(scene->triangle_count(), 2u);
  EXPECT_EQ(At(*scene, kDown).ng.z, 1);
  // A saddle z = uv, met where it is.
  mesh.positions[3].z = 1;
  SceneBuilder saddle;
  saddle.Add(mesh);
  const auto si = At(*saddle.Compile(), {{0.6f, 0.3f, 5}, {0, 0, -1}, kInfinity});
  EXPECT_NEAR(si.p.z, 0.18, 2e-4);
  EXPECT_GT(Dot(si.shading.n, Normalize(Vec3{-0.3f, -0.6f, 1})), 0.9999f);
}

TEST(Bounds, HoldEverything) {
  SceneBuilder b;
  b.Add(Flat());
  b.Add(SphereShape{1}, Transform::Translate({5, 0, 0}));
  b.Add(DiskShape{1, 0, 2}, Transform::Translate({0, -5, 0}));
  const auto bounds = b.Compile()->bounds();
  EXPECT_EQ(bounds.max.x, 6);
  EXPECT_EQ(bounds.min.y, -6);
  EXPECT_EQ(bounds.max.z, 2);
  EXPECT_TRUE(SceneBuilder().Compile()->bounds().empty());
}

// ---- identity ----

TEST(SceneHash, ChangesWithAnythingAndWithNothingElse) {
  const TemporaryFolder folder;
  const std::string path = folder / "hash.exr";
  WriteExr(path, FloatImage{2, 2, std::vector<Rgb>(4, Rgb(1))});
  const auto base = [&] {
    SceneBuilder b;
    TriangleMesh mesh = Flat();
    mesh.normals.assign(3, {0, 0, 1});
    mesh.uvs.assign(3, {0, 0});
    b.Add(mesh);
    b.AddLight(Flat(), Rgb(1), Transform::Translate({0, 0, 3}));
    b.Add(SphereShape{1}, Transform::Translate({5, 0, 0}));
    b.AddLight(InfiniteLight{Rgb(1), path});
    b.AddLight(SpotLight{Rgb(1), {0, 0, 1}, {0, 0, 0}});
    ImageTexture image;
    image.path = path;
    b.d.textures.push_back({"t", false, image, {}});
    return b;
  };
  const std::vector<std::function<void(SceneDescription&)>> changes{
      [](auto& d) { std::get<TriangleMesh>(d.shapes[0].kind).positions[0].x = -0.5f; },
      [](auto& d) { std::get<TriangleMesh>(d.shapes[0].kind).normals[0].x = 0.5f; },
      [](auto& d) { std::get<TriangleMesh>(d.shapes[0].kind).uvs[0].x = 0.5f; },
      [](auto& d) { std::get<SphereShape>(d.shapes[2].kind).radius = 2; },
      [](auto& d) { d.shapes[0].reverse_orientation = true; },
      [](auto& d) { d.shapes[0].alpha.value = 0.5f; },
      [](auto& d) { d.shapes[1].light->radiance.g = 2; },
      [](auto& d) { d.shapes[1].light->two_sided = true; },
      [](auto& d) { d.shapes[1].light->power = 2; },
      [](auto& d) { std::get<InfiniteLight>(d.lights[0].kind).radiance.r = 0.5f; },
      [](auto& d) {
        d.lights[0].world_from_light = Transform::Rotate(10, {0, 0, 1});
      },
      [](auto& d) { std::get<SpotLight>(d.lights[1].kind).cone_delta = 6; },
      [](auto& d) { std::get<ImageTexture>(d.textures[0].kind).wrap = ImageTexture::Wrap::kClamp; },
      [](auto& d) { std::get<ImageTexture>(d.textures[0].kind).mapping.su = 2; },
      [](auto& d) { std::get<DiffuseMaterial>(d.materials[0].kind).reflectance.value.r = 0.1f; },
      [](auto& d) { d.materials[0].kind = DielectricMaterial{}; },
      [](auto& d) { d.camera.fov = 40; },
      [](auto& d) { d.camera.lens_radius = 0.1f; },
      [](auto& d) {
        d.camera.camera_from_world = Transform::Translate({0, 0, 1});
      },
      [](auto& d) { d.resolution_x = 17; },
      [](auto& d) { d.filter.sigma = 0.4f; },
      [](auto& d) { d.max_depth = 6; },
  };
  std::set<std::string> hashes{base().Compile()->hash().hex};
  EXPECT_EQ(base().Compile()->hash().hex, *hashes.begin());
  for (size_t i = 0; i < changes.size(); ++i) {
    SceneBuilder b = base();
    changes[i](b.d);
    EXPECT_TRUE(hashes.insert(b.Compile()->hash().hex).second) << "change " << i;
  }
  WriteExr(path, FloatImage{2, 2, {Rgb(1), Rgb(1), Rgb(1), Rgb(2)}});
  EXPECT_TRUE(hashes.insert(base().Compile()->hash().hex).second) << "a texel";
}

TEST(SceneNeeds, SayWhatIsThere) {
  SceneBuilder b;
  b.Add(Flat());
  EXPECT_EQ(b.Compile()->needs().ToString(), "smooth-lobes");
  b.d.materials.push_back({"glass", DielectricMaterial{1.5f, {}}, {}});
  b.Add(SphereShape{1}).material = 1;
  b.AddLight(InfiniteLight{Rgb(1), ""});
  b.d.camera.lens_radius = 0.1f;
  EXPECT_EQ(b.Compile()->needs().ToString(), "environment delta-lobes smooth-lobes transmission quadrics lens");
}

TEST(SceneNeeds, SayWhatIsLeftOut) {
  SceneBuilder b;
  b.Add(Flat());
  EXPECT_EQ(b.Compile()->needs().NotNeeded(),
            "environment, textures and mixes, delta lobes (left out of the path kernel); "
            "alpha, instances, quadrics (left out of the intersector); lens (left out of camera rays); "
            "light samples (left out of all paths); "
            "guiding (left out of method 'auto')");
  b.d.materials.push_back({"glass", DielectricMaterial{1.5f, {}}, {}});
  b.Add(SphereShape{1}).material = 1;
  b.AddLight(InfiniteLight{Rgb(1), ""});
  EXPECT_EQ(b.Compile()->needs().NotNeeded(),
            "textures and mixes (left out of the path kernel); alpha, instances (left out of the intersector); "
            "lens (left out of camera rays)");
  SceneNeeds all{.textures = true,
                 .alpha = true,
                 .environment = true,
                 .delta_lobes = true,
                 .instances = true,
                 .quadrics = true,
                 .lens = true};
  EXPECT_EQ(all.NotNeeded(), "nothing");
  // Light, and nothing that guiding could turn towards it.
  all.smooth_lobes = false;
  EXPECT_EQ(all.NotNeeded(), "guiding (left out of method 'auto')");
}

TEST(Scene, EmptyAndBlackScenesCompile) {
  SceneBuilder b;
  const auto scene = b.Compile();
  Hit hit;
  EXPECT_FALSE(scene->Intersect(kDown, &hit));
  EXPECT_TRUE(scene->Unoccluded(kDown));
  EXPECT_FALSE(scene->has_lights());
  EXPECT_FALSE(scene->SampleLight({}, 0.5f, {}));
  b.AddLight(PointLight{Rgb(0), {0, 0, 0}});
  EXPECT_FALSE(b.Compile()->SampleLight({1, 0, 0}, 0.5f, {}));
}

}  // namespace
}  // namespace lodestar
