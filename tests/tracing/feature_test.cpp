// The feature pass on scenes whose answers are known.
#include <gtest/gtest.h>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/feature_pass.h"
#include "core/tracing/tracer.h"
#include "tests/statistical/small_scenes.h"
#include "tests/support/render.h"

namespace lodestar {
namespace {

CompiledJob Compile(const std::string& text, const JobSpec& job = {}) {
  return CompileJob(ParsePbrtText(text, "test.pbrt", "."), job);
}
TechniqueShares ByHeight(const SurfaceHit& hit) {
  return {0.5f + 0.25f * hit.si.p.y, 0.5f - 0.25f * hit.si.p.y};
}
// A wall at z = 2 that fills the right half of the picture, seen from the origin along +z.
std::string HalfWall(const std::string& material, const std::string& more = "") {
  return R"(Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
PixelFilter "box"
LookAt 0 0 0  0 0 1  0 1 0
Camera "perspective" "float fov" [40]
WorldBegin
)" + material +
         R"(
Shape "trianglemesh" "point3 P" [0 -9 2  9 -9 2  9 9 2  0 9 2] "integer indices" [0 1 2 0 2 3]
)" + more;
}
// Which half is the wall's: pbrt's camera is left-handed, so +x is to the right.
constexpr uint32_t kWall = 12, kNothing = 3;

TEST(FeaturePass, AlbedoNormalAndDepthOfAWall) {
  const CompiledJob compiled = Compile(HalfWall(R"(Material "diffuse" "rgb reflectance" [0.7 0.6 0.5])"));
  const Features f = RenderFeatures(*compiled.scene, 1, ByHeight);
  ASSERT_EQ(f.width, 16u);
  const size_t wall = 8 * 16 + kWall, nothing = 8 * 16 + kNothing;
  EXPECT_NEAR(f.albedo[wall].r, 0.7f, 1e-5f);
  EXPECT_NEAR(f.albedo[wall].b, 0.5f, 1e-5f);
  EXPECT_NEAR(f.normal[wall].z, -1, 1e-5f);  // towards the camera, whichever way the mesh is wound
  // Along the ray, not along the axis: the pixel's own angle shows.
  const float tan = Tan(Radians(20)) * (kWall + 0.5f - 8) / 8;
  EXPECT_NEAR(f.depth[wall], 2 * std::sqrt(1 + tan * tan), 0.02f);
  EXPECT_EQ(f.albedo[nothing], Rgb(0));
  EXPECT_EQ(f.normal[nothing], Vec3());
  EXPECT_EQ(f.depth[nothing], kInfinity);
  EXPECT_EQ(f.bsdf_fraction[nothing], 0);
  // The shares are those of the surface that the pixel sees: more at the top.
  EXPECT_GT(f.bsdf_fraction[2 * 16 + kWall], 0.55f);
  EXPECT_LT(f.bsdf_fraction[13 * 16 + kWall], 0.45f);
  EXPECT_NEAR(f.nee[2 * 16 + kWall], 1 - f.bsdf_fraction[2 * 16 + kWall], 1e-5f);
}

TEST(FeaturePass, APixelOnAnEdgeIsTheMeanOfItsSamples) {
  // Shifted by a quarter of a pixel: of column 8, three quarters are wall.
  const float shift = 2 * Tan(Radians(20)) * 0.25f / 8;
  const std::string scene = HalfWall(R"(Material "diffuse" "rgb reflectance" [0.8 0.8 0.8]
Translate )" + std::to_string(shift) +
                                     " 0 0");
  const Features f = RenderFeatures(*Compile(scene).scene, 1, ByHeight);
  EXPECT_NEAR(f.albedo[8 * 16 + 8].r, 0.6f, 1e-4f);  // the samples are stratified: 12 of 16 exactly
  EXPECT_NEAR(f.normal[8 * 16 + 8].z, -0.75f, 1e-4f);
  EXPECT_NEAR(f.depth[8 * 16 + 8], 2, 0.02f);  // over those that hit
}

TEST(FeaturePass, SharesAreThoseBehindAMirrorTheRestIsItsOwn) {
  // A mirror that shows a wall at z = -3.
  const CompiledJob compiled = Compile(HalfWall(R"(Material "conductor" "float roughness" 0)", R"(Material "diffuse"
Shape "trianglemesh" "point3 P" [-99 -99 -3  99 -99 -3  99 99 -3  -99 99 -3] "integer indices" [0 1 2 0 2 3])"));
  const Features f = RenderFeatures(*compiled.scene, 1, [](const SurfaceHit& hit) {
    return TechniqueShares{hit.si.p.z < -2.9f ? 0.25f : 0.75f, 1};
  });
  EXPECT_NEAR(f.depth[8 * 16 + kWall], 2, 0.2f);
  EXPECT_NEAR(f.normal[8 * 16 + kWall].z, -1, 1e-5f);
  EXPECT_GT(f.albedo[8 * 16 + kWall].r, 0.3f);
  EXPECT_EQ(f.bsdf_fraction[8 * 16 + kWall], 0.25f);
}

TEST(FeaturePass, ThreadsDoNotShow) {
  const CompiledJob compiled = Compile(test::kSmallScenes[1].text);
  const Features one = RenderFeatures(*compiled.scene, 5, ByHeight, 1),
                 three = RenderFeatures(*compiled.scene, 5, ByHeight, 3);
  EXPECT_EQ(one.albedo, three.albedo);
  EXPECT_EQ(one.normal, three.normal);
  EXPECT_EQ(one.bsdf_fraction, three.bsdf_fraction);
  const Features other = RenderFeatures(*compiled.scene, 6, ByHeight);
  EXPECT_NE(one.albedo, other.albedo);
}

TEST(FeaturePass, SharesAreWhatTheMethodUses) {
  const CompiledJob compiled = Compile(test::kSmallScenes[0].text);
  JobSpec job;
  job.method = "path";
  const SurfaceHit anywhere{};
  const auto shares = [&](const std::shared_ptr<const State>& state) {
    const auto method = MakeMethod(job, compiled.survey);
    return SharesOf(*compiled.scene, *method, state ? state : method->Initial())(anywhere);
  };
  EXPECT_EQ(shares(nullptr).bsdf_fraction, 1);
  EXPECT_EQ(shares(nullptr).nee_probability, 1);
  job.options["nee"] = "never";
  EXPECT_EQ(shares(nullptr).nee_probability, 0);

  // A tree that has learned nothing does not guide; one that has, does.
  job.method = "sdtree";
  job.options = {{"bsdf-fraction", "0.3"}, {"product", "off"}, {"nee", "always"}};
  job.budget.spp = 15;
  job.training_iterations = 3;
  EXPECT_EQ(shares(nullptr).bsdf_fraction, 1);
  const auto bytes = test::Render(compiled, job).state;
  const auto learned = shares(MakeMethod(job, compiled.survey)->ParseState(bytes));
  EXPECT_FLOAT_EQ(learned.bsdf_fraction, 0.3f);
  EXPECT_EQ(learned.nee_probability, 1);
}

}  // namespace
}  // namespace lodestar
