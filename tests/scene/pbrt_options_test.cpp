// What stands before WorldBegin.
#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

SceneDescription Options(const std::string& text) {
  return Parse(text + "\nWorldBegin");
}
std::string CameraWith(const std::string& params) {
  return "Camera \"perspective\" " + params;
}

TEST(PbrtOptions, DefaultsArePbrts) {
  const auto scene = Options("");
  EXPECT_EQ(scene.max_depth, 5);
  EXPECT_EQ(scene.samples_per_pixel, 16);
  EXPECT_EQ(scene.resolution_x, 1280);
  EXPECT_EQ(scene.resolution_y, 720);
  EXPECT_EQ(scene.filter.kind, PixelFilterDescription::Kind::kGaussian);
  EXPECT_EQ(scene.filter.radius_x, 1.5f);
  EXPECT_EQ(scene.filter.sigma, 0.5f);
  EXPECT_EQ(scene.camera.fov, 90);
  EXPECT_EQ(scene.camera.lens_radius, 0);
  EXPECT_EQ(scene.camera.focal_distance, 1e6f);
  EXPECT_EQ(scene.camera.screen_window, (std::array<float, 4>{0, 0, 0, 0}));
  EXPECT_TRUE(scene.camera.camera_from_world.IsIdentity());
}

TEST(PbrtOptions, IntegratorsGiveTheirDepth) {
  for (const char* type :
       {"path", "volpath", "simplepath", "simplevolpath", "bdpt", "mlt", "sppm", "lightpath", "randomwalk"})
    EXPECT_EQ(Options(std::string("Integrator \"") + type + "\" \"integer maxdepth\" 17").max_depth, 17) << type;
  EXPECT_EQ(Options("Integrator \"path\"").max_depth, 5);
  EXPECT_EQ(Options("Integrator \"path\" \"bool regularize\" false \"string lightsampler\" \"bvh\" \"bool "
                    "samplelights\" true \"bool samplebsdf\" true")
                .max_depth,
            5);
  Options("Integrator \"bdpt\" \"bool visualizestrategies\" false \"bool visualizeweights\" false");
  Options(
      "Integrator \"mlt\" \"integer bootstrapsamples\" 1 \"integer chains\" 1 \"integer mutationsperpixel\" 1 \"float "
      "largestepprobability\" .1 \"float sigma\" .1");
  Options("Integrator \"sppm\" \"integer photonsperiteration\" 1 \"float radius\" 1 \"integer seed\" 1");
}

TEST(PbrtOptions, SamplersGiveTheirCount) {
  for (const char* type : {"halton", "independent", "paddedsobol", "sobol", "zsobol", "pmj02bn"})
    EXPECT_EQ(Options(std::string("Sampler \"") + type +
                      "\" \"integer pixelsamples\" 64 \"string randomization\" \"owen\" \"integer seed\" 3")
                  .samples_per_pixel,
              64)
        << type;
  EXPECT_EQ(Options("Sampler \"stratified\"").samples_per_pixel, 16);
  EXPECT_EQ(Options("Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5 \"bool jitter\" true")
                .samples_per_pixel,
            15);
}

TEST(PbrtOptions, FiltersHavePbrtsDefaults) {
  using Kind = PixelFilterDescription::Kind;
  const struct {
    const char* text;
    Kind kind;
    float x, y;
  } cases[] = {{"\"box\"", Kind::kBox, 0.5f, 0.5f},
               {"\"triangle\"", Kind::kTriangle, 2, 2},
               {"\"gaussian\"", Kind::kGaussian, 1.5f, 1.5f},
               {"\"mitchell\"", Kind::kMitchell, 2, 2},
               {"\"box\" \"float xradius\" 1 \"float yradius\" 3", Kind::kBox, 1, 3}};
  for (const auto& c : cases) {
    const auto filter = Options(std::string("PixelFilter ") + c.text).filter;
    EXPECT_EQ(filter.kind, c.kind) << c.text;
    EXPECT_EQ(filter.radius_x, c.x) << c.text;
    EXPECT_EQ(filter.radius_y, c.y) << c.text;
  }
  EXPECT_EQ(Options("PixelFilter \"gaussian\" \"float sigma\" 0.7").filter.sigma, 0.7f);
  EXPECT_EQ(Options("PixelFilter \"mitchell\"").filter.b, 1 / 3.0f);
  EXPECT_EQ(Options("PixelFilter \"mitchell\"").filter.c, 1 / 3.0f);
  EXPECT_EQ(Options("PixelFilter \"mitchell\" \"float B\" 0.1 \"float C\" 0.2").filter.b, 0.1f);
  EXPECT_EQ(Options("PixelFilter \"mitchell\" \"float B\" 0.1 \"float C\" 0.2").filter.c, 0.2f);
}

TEST(PbrtOptions, FilmGivesTheResolution) {
  const auto scene = Options(
      "Film \"rgb\" \"integer xresolution\" [640] \"integer yresolution\" 480 \"string filename\" \"a.exr\" \"float "
      "diagonal\" 35 \"bool savefp16\" false \"string sensor\" \"cie1931\""
      " \"float exposuretime\" 1 \"float whitebalance\" 0 \"float cropwindow\" [0 1 0 1]");
  EXPECT_EQ(scene.resolution_x, 640);
  EXPECT_EQ(scene.resolution_y, 480);
}

TEST(PbrtOptions, PerspectiveCamera) {
  const auto camera = Options(CameraWith("\"float fov\" 35 \"float lensradius\" .1 \"float focaldistance\" 4 \"float "
                                         "screenwindow\" [-2 2 -1 1]"))
                          .camera;
  EXPECT_EQ(camera.fov, 35);
  EXPECT_EQ(camera.lens_radius, 0.1f);
  EXPECT_EQ(camera.focal_distance, 4);
  EXPECT_EQ(camera.screen_window, (std::array<float, 4>{-2, 2, -1, 1}));
  EXPECT_EQ(Options(CameraWith("\"float frameaspectratio\" 2")).camera.screen_window,
            (std::array<float, 4>{-2, 2, -1, 1}));
  EXPECT_EQ(Options(CameraWith("\"float frameaspectratio\" .5")).camera.screen_window,
            (std::array<float, 4>{-1, 1, -2, 2}));
}

// pbrt-v4's film measures exposure time * iso / 100 of the light.
TEST(PbrtOptions, ExposureScalesAllLights) {
  const std::string lights = R"(
    WorldBegin
    LightSource "point" LightSource "spot" LightSource "distant" "float illuminance" 3 LightSource "infinite"
    LightSource "infinite" "string filename" "image.png" "float illuminance" 5
    AttributeBegin AreaLightSource "diffuse" Shape "sphere" AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "float power" 10 Shape "sphere" AttributeEnd)";
  const auto plain = Parse(lights);
  const auto expect = [&](const std::string& options, float ratio, bool lenient = false) {
    SCOPED_TRACE(options);
    const auto scene = Parse(options + lights, lenient);
    const auto times = [ratio](Rgb actual, Rgb unscaled) { ExpectRgb(actual, unscaled * ratio, 1e-5f * ratio); };
    const auto strength = [](const LightDescription& light) {
      const auto get = [](const auto& kind) {
        if constexpr (requires { kind.intensity; })
          return kind.intensity;
        else
          return kind.radiance;
      };
      return std::visit(get, light.kind);
    };
    ASSERT_EQ(scene.lights.size(), 5u);
    for (size_t i = 0; i < 5; ++i) times(strength(scene.lights[i]), strength(plain.lights[i]));
    EXPECT_EQ(Get<InfiniteLight>(scene.lights[4].kind).illuminance, 5);  // the scale multiplies it
    times(scene.shapes[0].light->radiance, plain.shapes[0].light->radiance);
    EXPECT_NEAR(scene.shapes[1].light->power, 10 * ratio, 1e-4f * ratio);
    times(scene.shapes[1].light->radiance, plain.shapes[1].light->radiance / ratio);
  };
  expect("Film \"rgb\" \"float iso\" 200", 2);
  expect("Film \"gbuffer\" \"float iso\" 50 \"string coordinatesystem\" \"world\"", 0.5f);
  expect(CameraWith("\"float shutteropen\" 1 \"float shutterclose\" 1.25"), 0.25f);
  expect(CameraWith("\"float shutterclose\" 0.5") + " Film \"rgb\" \"float iso\" 400", 2);
  // Of what is left out, too.
  expect("Film \"spectral\" \"float iso\" 200 \"integer nbuckets\" 4", 2, true);
  expect("Camera \"orthographic\" \"float shutterclose\" 0.5", 0.5f, true);
}

TEST(PbrtOptions, AcceptsWhatDoesNotMatter) {
  Options("ColorSpace \"srgb\" Accelerator \"bvh\" \"integer maxnodeprims\" 4 \"string splitmethod\" \"sah\"");
  Options(
      "Accelerator \"kdtree\" \"integer intersectcost\" 5 \"integer traversalcost\" 1 \"float emptybonus\" .5 "
      "\"integer maxprims\" 1 \"integer maxdepth\" -1");
  Options(
      "Option \"integer seed\" 5 Option \"seed\" [5] Option \"string rendercoordsys\" \"world\" Option \"bool "
      "disablewavelengthjitter\" true Option \"float displacementedgescale\" 1");
  Options(
      "Option \"string msereferenceimage\" \"a\" Option \"string msereferenceout\" \"a\" Option \"bool pixelstats\" "
      "true Option \"bool wavefront\" true");
  Options(
      "Option \"bool disablepixeljitter\" false Option \"bool disabletexturefiltering\" false Option \"bool "
      "forcediffuse\" false");
  Options("MediumInterface \"\" \"\"");
}

TEST(PbrtOptions, RefusesByNameAndPlace) {
  const Refused cases[] = {
      {"Integrator \"ambientocclusion\"", kNo, "1:1", "another image"},
      {"Integrator \"function\"", kNo, "1:1", "another image"},
      {"Integrator \"whitted\"", kBad, "1:1", "supported here: path"},
      {"Integrator \"path\" \"integer maxdepth\" -1", kBad, "1:1", "must not be negative"},
      {"Integrator \"path\" \"bool regularize\" true", kNo, "1:19", "changes the image"},
      {"Integrator \"bdpt\" \"bool visualizestrategies\" true", kNo, "1:19", "debugging"},
      {"Integrator \"bdpt\" \"bool visualizeweights\" true", kNo, "1:19", "debugging"},
      {"Integrator \"path\" \"integer chains\" 4", kBad, "1:19", "not used"},
      {"Sampler \"random\"", kBad, "1:1", "supported here: halton"},
      {"Sampler \"sobol\" \"integer pixelsamples\" 0", kBad, "1:1", "greater than 0"},
      {"Sampler \"sobol\" \"integer xsamples\" 2", kBad, "1:17", "not used"},
      {"Sampler \"stratified\" \"integer xsamples\" 0", kBad, "1:1", "greater than 0"},
      {"Sampler \"stratified\" \"integer xsamples\" 100000 \"integer ysamples\" 100000", kBad, "1:1", "greater than 0"},
      {"PixelFilter \"sinc\"", kNo, "1:1", "use mitchell"},
      {"PixelFilter \"lanczos\"", kBad, "1:1", "box, triangle"},
      {"PixelFilter \"box\" \"float xradius\" 0", kBad, "1:19", "greater than 0"},
      {"PixelFilter \"box\" \"float yradius\" -1", kBad, "1:19", "greater than 0"},
      {"PixelFilter \"gaussian\" \"float sigma\" 0", kBad, "1:24", "greater than 0"},
      {"PixelFilter \"box\" \"float sigma\" 1", kBad, "1:19", "not used"},
      {"PixelFilter \"box\" \"float B\" 1", kBad, "1:19", "not used"},
      {"Film \"spectral\"", kNo, "1:1", "use rgb"},
      {"Film \"image\"", kBad, "1:1", "supported here: rgb"},
      {"Film \"rgb\" \"integer xresolution\" 0", kBad, "1:1", "resolution 0 x 720"},
      {"Film \"rgb\" \"integer yresolution\" 70000", kBad, "1:1", "65536"},
      {"Film \"rgb\" \"integer xresolution\" 16384 \"integer yresolution\" 16385", kBad, "1:1", "268435456 pixels"},
      {"Film \"rgb\" \"float cropwindow\" [0 .5 0 1]", kNo, "1:12", "changes the image"},
      {"Film \"rgb\" \"integer pixelbounds\" [0 5 0 5]", kNo, "1:12", "changes the image"},
      {"Film \"rgb\" \"float maxcomponentvalue\" 10", kNo, "1:12", "changes the image"},
      {"Film \"rgb\" \"float iso\" 0", kBad, "1:12", "greater than 0"},
      {"Film \"gbuffer\" \"float whitebalance\" 5000", kNo, "1:16", "changes the image"},
      {"Film \"gbuffer\" \"integer nbuckets\" 4", kBad, "1:16", "not used"},
      {"Film \"rgb\" \"float exposuretime\" 2", kNo, "1:12", "changes the image"},
      {"Film \"rgb\" \"float whitebalance\" 5000", kNo, "1:12", "changes the image"},
      {"Film \"rgb\" \"string sensor\" \"canon_eos_5d\"", kNo, "1:12", "only cie1931"},
      {"Camera \"orthographic\"", kNo, "1:1", "use perspective"},
      {"Camera \"realistic\"", kNo, "1:1", "use perspective"},
      {"Camera \"spherical\"", kNo, "1:1", "use perspective"},
      {"Camera \"pinhole\"", kBad, "1:1", "supported here: perspective"},
      {"Camera \"perspective\" \"float fov\" 0", kBad, "1:1", "between 0 and 180"},
      {"Camera \"perspective\" \"float fov\" 180", kBad, "1:1", "between 0 and 180"},
      {"Camera \"perspective\" \"float shutteropen\" 1", kBad, "1:1", "later than"},
      {"Camera \"perspective\" \"float lensradius\" -1", kBad, "1:22", "negative"},
      {"Camera \"perspective\" \"float focaldistance\" 0", kBad, "1:22", "greater than 0"},
      {"Camera \"perspective\" \"float frameaspectratio\" 0", kBad, "1:22", "greater than 0"},
      {"Camera \"perspective\" \"float screenwindow\" [1 2 3]", kBad, "1:1", "four numbers"},
      {"Camera \"perspective\" \"float screenwindow\" [1 -1 -1 1]", kBad, "1:1", "x0 < x1"},
      {"ColorSpace \"rec2020\"", kNo, "1:1", "use srgb"},
      {"ColorSpace \"aces2065-1\"", kNo, "1:1", "use srgb"},
      {"ColorSpace \"dci-p3\"", kNo, "1:1", "use srgb"},
      {"ColorSpace \"adobe\"", kBad, "1:1", "supported here: srgb"},
      {"Option \"bool disablepixeljitter\" true", kNo, "1:1", "changes the image"},
      {"Option \"bool disabletexturefiltering\" true", kNo, "1:1", "changes the image"},
      {"Option \"bool forcediffuse\" true", kNo, "1:1", "changes the image"},
      {"Option \"bool forcediffuse\" maybe", kBad, "1:28", "true or false"},
      {"Option \"bool makeitnice\" true", kBad, "1:1", "no Option \"makeitnice\""},
      {"Option \"seed\" ]", kBad, "1:15", "expected the value"},
      {"Option \"seed\" [1 2]", kBad, "1:16", "one value"},
      {"Accelerator \"octree\"", kBad, "1:1", "bvh, kdtree"},
      {"Accelerator \"bvh\" \"float emptybonus\" 1", kBad, "1:19", "not used"},
      {"MediumInterface \"fog\" \"\"", kNo, "1:1", "no participating media"},
      {"MediumInterface \"fog\"", kNo, "1:1", "no participating media"},
      {"MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"", kNo, "1:1", "no participating media"},
  };
  for (const Refused& c : cases) ExpectRefused(c, false);
}

}  // namespace
}  // namespace lodestar
