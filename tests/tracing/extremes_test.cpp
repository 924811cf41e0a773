// Stiff and extreme scenes: finite, unbiased numbers, or a clear refusal. Units and distances must not matter, so most
// cases compare a scene with itself at another scale.
#include <gtest/gtest.h>

#include <cmath>

#include "core/learning/grid_guiding.h"
#include "core/learning/mixed_guiding.h"
#include "tests/statistical/small_scenes.h"
#include "tests/support/render.h"
#include "tests/support/statistical.h"
#include "tests/tracing/job_text.h"

namespace lodestar {
namespace {

double Mean(const Image& image) {
  double sum = 0;
  for (const Rgb pixel : image.pixels) sum += Luminance(pixel);
  return sum / static_cast<double>(image.size());
}

bool AllFinite(const Image& image) {
  return std::all_of(image.pixels.begin(), image.pixels.end(),
                     [](Rgb p) { return IsFinite(p) && MinComponent(p) >= 0; });
}

JobSpec Job(const std::string& method, uint64_t spp = 31, std::map<std::string, std::string> options = {}) {
  JobSpec job;
  job.method = method;
  job.options = std::move(options);
  if (method == "grid") job.options = {{"batch", "2"}, {"steps", "4"}};
  if (method == "auto") job.options = {{"pilot", "1000"}};  // a race, however small the picture
  job.budget.spp = spp;
  job.seed = 3;
  return job;
}

std::vector<JobSpec> Jobs() {
  return {Job("path"), Job("sdtree"), Job("grid"),
          // The mean of a focal-guided image of 31 spp spreads by a hundredth; another scale is as good as another seed
          // to it.
          Job("focal", 127),
          // Learns its full target, which four iterations come before.
          Job("sdtree", 47, {{"training", "5"}}), Job("sdtree", 31, {{"product", "on"}}), Job("sdtree+focal"),
          Job("auto")};
}

const std::vector<std::string> kMethods = {"path", "sdtree", "focal", "grid", "sdtree+focal", "auto"};

std::string Number(double v) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.9g", v);
  return text;
}

// A lit diffuse room of the given size, `away` units from the origin along every axis.
std::string ScaledRoom(double s, double away, double emission) {
  const auto p = [&](double x, double y, double z) {
    return Number(x * s + away) + " " + Number(y * s + away) + " " + Number(z * s + away) + "  ";
  };
  return R"(Integrator "path" "integer maxdepth" [6]
PixelFilter "box"
Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
LookAt )" +
         p(0, 0, -3.4) + p(0, 0, 0) + R"( 0 1 0
Camera "perspective" "float fov" [40]
WorldBegin
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "point3 P" [)" +
         p(-1, -1, -1) + p(1, -1, -1) + p(1, -1, 1) + p(-1, -1, 1) + p(-1, 1, -1) + p(1, 1, -1) + p(1, 1, 1) +
         p(-1, 1, 1) +
         R"(] "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  3 6 2 3 7 6  0 4 7 0 7 3  1 2 6 1 6 5]
AreaLightSource "diffuse" "rgb L" [)" +
         Number(emission) + " " + Number(emission) + " " + Number(emission) + R"(]
Shape "trianglemesh" "point3 P" [)" +
         p(-0.4, 0.9, -0.4) + p(0.4, 0.9, -0.4) + p(0.4, 0.9, 0.4) + p(-0.4, 0.9, 0.4) +
         R"(] "integer indices" [0 1 2 0 2 3]
)";
}

TEST(ExtremesTest, EmissionFrom1e12thTo1e12) {
  for (const JobSpec& job : Jobs()) {
    SCOPED_TRACE(Text(job));
    const double unit = Mean(test::RenderText(ScaledRoom(1, 0, 1), job).image);
    ASSERT_GT(unit, 0);
    for (const double emission : {1e-12, 1e-6, 1e6, 1e12}) {
      const Image image = test::RenderText(ScaledRoom(1, 0, emission), job).image;
      EXPECT_TRUE(AllFinite(image));
      EXPECT_NEAR(Mean(image) / emission / unit, 1, job.method == "path" ? 1e-4 : 0.02) << "at " << emission;
    }
  }
}

// The open room, lit from within by what cannot be hit, or by a sky of one colour through its front.
std::string RoomLitBy(const std::string& light, double strength) {
  return test::Room("LightSource " + light + " \"float scale\" [" + Number(strength) + "]\n");
}

TEST(ExtremesTest, PointsSpotsAndSkiesFrom1e12thTo1e12) {
  for (const char* light :
       {R"("point" "rgb I" [1 1 1] "point3 from" [0 0.5 0])",
        R"("spot" "rgb I" [1 1 1] "point3 from" [0 0.5 0] "point3 to" [0 -1 0.2] "float coneangle" [40])",
        R"("distant" "rgb L" [1 1 1] "point3 from" [0.3 0.4 -1] "point3 to" [0 0 0])",
        R"("infinite" "rgb L" [1 1 1])"}) {
    for (const JobSpec& job : Jobs()) {
      SCOPED_TRACE(Text(job));
      const double unit = Mean(test::RenderText(RoomLitBy(light, 1), job).image);
      ASSERT_GT(unit, 0) << light;
      for (const double strength : {1e-12, 1e12}) {
        const test::Rendered rendered = test::RenderText(RoomLitBy(light, strength), job);
        EXPECT_TRUE(AllFinite(rendered.image));
        // Sums that an SD-tree learns from may end at their range up there: counted, and no matter to the image.
        HealthReport health = rendered.report.health;
        health.counts[static_cast<size_t>(HealthEvent::kSaturated)] = 0;
        EXPECT_EQ(health.total(), 0u) << light << " at " << strength;
        EXPECT_NEAR(Mean(rendered.image) / strength / unit, 1, job.method == "path" ? 1e-4 : 0.02)
            << light << " at " << strength;
      }
    }
  }
}

TEST(ExtremesTest, SceneExtentsFrom1e4thTo1e7AndFarFromTheOrigin) {
  for (const JobSpec& job : Jobs()) {
    SCOPED_TRACE(Text(job));
    const double unit = Mean(test::RenderText(ScaledRoom(1, 0, 1), job).image);
    for (const double scale : {1e-4, 1e-2, 1e3, 1e7}) {
      const test::Rendered rendered = test::RenderText(ScaledRoom(scale, 0, 1), job);
      EXPECT_EQ(rendered.report.health.total(), 0u) << "at scale " << scale;
      EXPECT_NEAR(Mean(rendered.image) / unit, 1, job.method == "focal" ? 0.02 : 0.01) << "at scale " << scale;
    }
    // A million units away single precision leaves a sixteenth of a unit: a room of 100 units keeps its light.
    const double far = Mean(test::RenderText(ScaledRoom(100, 1e6, 1), job).image);
    EXPECT_NEAR(far / unit, 1, 0.02);
  }
}

// A sphere that subtends 1e-7 sr over a diffuse floor lights it as its solid angle says.
TEST(ExtremesTest, ALightOfATenMillionthSteradian) {
  const double distance = 10, solid_angle = 1e-7;
  const double radius = distance * std::sqrt(solid_angle / M_PI);
  const std::string text = R"(PixelFilter "box"
Film "rgb" "integer xresolution" [4] "integer yresolution" [4]
LookAt 0 1 0  0 0 0  0 0 1
Camera "perspective" "float fov" [2]
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "point3 P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9] "integer indices" [0 2 1 0 3 2]
Translate 0 )" + Number(distance) +
                           R"( 0
AreaLightSource "diffuse" "rgb L" [1e7 1e7 1e7]
Shape "sphere" "float radius" [)" +
                           Number(radius) + "]\n";
  for (const std::string& method : kMethods) {
    const Image image = test::RenderText(text, Job(method)).image;
    EXPECT_NEAR(Mean(image), 0.5 / M_PI * 1e7 * solid_angle, 1e-3 * 0.5 / M_PI) << method;
  }
}

// Whether a state knows of any light.
bool Knows(const State& state) {
  if (const auto* tree = dynamic_cast<const SdTreeState*>(&state)) {
    for (uint32_t leaf = 0; leaf < tree->tree().leaf_count(); ++leaf)
      if (tree->tree().HasLearned(leaf)) return true;
  }
  if (const auto* focal = dynamic_cast<const FocalState*>(&state)) return focal->field().HasLearned();
  if (const auto* grid = dynamic_cast<const GridState*>(&state)) {
    for (uint32_t cell = 0; cell < grid->grid()->cell_count(); ++cell)
      if (grid->grid()->Fluence(cell) > 0) return true;
  }
  if (const auto* both = dynamic_cast<const MixedState*>(&state)) return Knows(*both->tree()) && Knows(*both->focal());
  return false;
}

// Behind the camera in a closed room: half of the light comes by way of the walls, which all guides learn of, and none
// may move the mean.
TEST(ExtremesTest, ALightOfATenMillionthSteradianInAClosedRoom) {
  const std::string text = R"(PixelFilter "box"
Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
LookAt 0 0 -0.4  0 0 1  0 1 0
Camera "perspective" "float fov" [60]
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "point3 P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1  -1 1 -1  1 1 -1  1 1 1  -1 1 1]
  "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  3 6 2 3 7 6  0 4 7 0 7 3  1 2 6 1 6 5  0 1 5 0 5 4]
Translate 0 0.3 -0.6
AreaLightSource "diffuse" "rgb L" [1e7 1e7 1e7]
Shape "sphere" "float radius" [)" +
                           Number(std::sqrt(1e-7 / M_PI)) + "]\n";
  const Image path = test::RenderText(text, Job("path", 127)).image;
  const double mean = Mean(path);
  ASSERT_GT(mean, 0.01);
  for (const std::string& method : kMethods) {
    if (method == "path") continue;
    JobSpec job = Job(method, 127);
    job.seed = 4;
    const test::Rendered rendered = test::RenderText(text, job);
    test::Moments differences;
    for (size_t i = 0; i < path.size(); ++i)
      differences.Add((Luminance(rendered.image.pixels[i]) - Luminance(path.pixels[i])) / mean);
    const test::TestResult result = test::TTest(differences, 0, test::SidakLevel(0.01, 5), 5e-3);
    EXPECT_TRUE(result.accepted) << method << ": " << result.message;
    EXPECT_LT(differences.standard_error(), 0.03) << method;  // so that much would be seen
    // What auto chooses may learn nothing.
    if (method == "auto") continue;
    const auto state = MakeMethod(rendered.report.job, rendered.report.survey)->ParseState(rendered.state);
    EXPECT_TRUE(Knows(*state)) << method;
  }
}

// A ten-thousandth above a floor of albedo 1/2 under a sky of radiance 1, along it: every ray of the lower half meets
// the floor at less than two degrees.
TEST(ExtremesTest, ACameraThatGrazesAFloor) {
  const std::string text = R"(PixelFilter "box"
Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
LookAt 0 1e-4 0  0 1e-4 1  0 1 0
Camera "perspective" "float fov" [2]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "point3 P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9] "integer indices" [0 2 1 0 3 2]
)";
  for (const std::string& method : kMethods) {
    const test::Rendered rendered = test::RenderText(text, Job(method, 127));
    EXPECT_EQ(rendered.report.health.total(), 0u) << method;
    test::Moments floor;
    for (size_t i = 0; i < rendered.image.size(); ++i) {
      const float pixel = Luminance(rendered.image.pixels[i]);
      if (i < rendered.image.size() / 2) {
        EXPECT_NEAR(pixel, 1, 1e-4) << method;
      } else {
        floor.Add(pixel);
      }
    }
    // Half a per cent of the topmost of its eight rows looks past the floor's edge: 4e-4 of 0.5.
    const test::TestResult result = test::TTest(floor, 0.5, test::SidakLevel(0.01, 6), 1e-3);
    EXPECT_TRUE(result.accepted) << method << ": " << result.message;
    EXPECT_LT(floor.standard_error(), 0.01) << method;
  }
}

// Its light never reaches the picture. Nobody is better than anybody at that: the race ends with the simplest.
TEST(ExtremesTest, ALampShutInABoxUnderAuto) {
  JobSpec job = Job("auto", 2047);
  job.resolution_x = job.resolution_y = 8;  // an iteration of focal guiding has 64 passes
  const test::Rendered rendered = test::RenderText(test::Room(test::kLampShutInABox), job);
  EXPECT_EQ(Mean(rendered.image), 0);
  EXPECT_EQ(rendered.report.passes, 2047u);
  EXPECT_EQ(rendered.report.stop_reason, "spp");
  EXPECT_EQ(rendered.report.health.total(), 0u);
  const std::string& choice = rendered.report.choice;
  EXPECT_TRUE(choice.starts_with("path; ")) << choice;
  for (const char* other : {"; sdtree left out: path was 1 times", "; focal left out: path was 1 times"})
    EXPECT_NE(choice.find(other), std::string::npos) << choice;
}

TEST(ExtremesTest, BlackSceneOneSampleOnePixel) {
  for (const std::string& method : kMethods) {
    const test::Rendered black = test::RenderText(test::Room(""), Job(method, 7));
    EXPECT_EQ(Mean(black.image), 0);
    EXPECT_EQ(black.report.health.total(), 0u);
    const test::Rendered one = test::RenderText(test::kSmallScenes[0].text, Job(method, 1));
    EXPECT_EQ(one.report.passes, 1u);
    EXPECT_TRUE(AllFinite(one.image));
    JobSpec pixel = Job(method, 7);
    pixel.resolution_x = pixel.resolution_y = 1;
    EXPECT_EQ(test::RenderText(test::kSmallScenes[0].text, pixel).image.size(), 1u);
  }
}

TEST(ExtremesTest, RoughnessIndexAndAlbedoAtTheirEnds) {
  for (const char* material :
       {R"("conductor" "float roughness" [1e-4] "bool remaproughness" [false])",
        R"("conductor" "float roughness" [1] "bool remaproughness" [false])", R"("dielectric" "float eta" [1])",
        R"("dielectric" "float eta" [1.0001])", R"("dielectric" "float eta" [1.0001] "float roughness" [0.3])",
        R"("dielectric" "float eta" [4] "float roughness" [1] "bool remaproughness" [false])",
        R"("diffuse" "rgb reflectance" [1 1 1])", R"("diffuse" "rgb reflectance" [0 0 0])",
        R"("coateddiffuse" "rgb reflectance" [1 1 1] "float roughness" [0])",
        R"("coateddiffuse" "rgb reflectance" [1 1 1] "float roughness" [1e-4] "bool remaproughness" [false])",
        R"("coatedconductor")"}) {
    for (const JobSpec& job : Jobs()) {
      SCOPED_TRACE(Text(job));
      const test::Rendered rendered =
          test::RenderText(test::Room(std::string(R"(AreaLightSource "diffuse" "rgb L" [5 5 5] "bool twosided" [true]
Shape "disk" "float radius" [0.3]
AttributeBegin
Translate 0.4 -0.5 -0.3
Material )") + material + R"(
Shape "sphere" "float radius" [0.4]
AttributeEnd
)",
                                      std::string("Material ") + material),
                           job);
      EXPECT_TRUE(AllFinite(rendered.image)) << material;
      EXPECT_EQ(rendered.report.health.counts[static_cast<int>(HealthEvent::kNan)], 0u) << material;
      EXPECT_EQ(rendered.report.health.counts[static_cast<int>(HealthEvent::kInfinite)], 0u) << material;
    }
  }
}

// A disk seen from straight above, in a sky of radiance 1 on both of its sides: its colour is the albedo of its
// material.
TEST(ExtremesTest, AlbedosAtTheEndsOfTheirRangeAreWhatTheyMustBe) {
  struct Case {
    const char* material;
    double albedo, bias = 0;
  };
  for (const Case& c : {
           Case{R"("diffuse" "rgb reflectance" [0 0 0])", 0},
           Case{R"("diffuse" "rgb reflectance" [1 1 1])", 1, 1e-4},
           Case{R"("diffusetransmission" "rgb reflectance" [0 0 0] "rgb transmittance" [1 1 1])", 1, 1e-4},
           Case{R"("dielectric" "float eta" [1])", 1},
           Case{R"("dielectric" "float eta" [1] "float roughness" [1])", 1},
           Case{R"("thindielectric" "float eta" [100])", 1},
           // The parser's reflectance of 1 is 0.9999 to a conductor; below alpha 0.001 it is a mirror.
           Case{R"("conductor" "rgb reflectance" [1 1 1] "float roughness" [1e-4] "bool remaproughness" [false])",
                0.9999, 1e-5},
           Case{R"("conductor" "rgb reflectance" [1 1 1] "float roughness" [1])", 1 - std::log(2.0),
                1e-4},  // decision 0019
           // The coat keeps all energy, but for its table's 0.2 % (decision 0005).
           Case{R"("coateddiffuse" "rgb reflectance" [1 1 1])", 1, 3e-3},
           Case{R"("coateddiffuse" "rgb reflectance" [1 1 1] "float roughness" [1])", 1, 3e-3},
       }) {
    for (const std::string& method : kMethods) {
      const Image image = test::RenderText(std::string(R"(PixelFilter "box"
Film "rgb" "integer xresolution" [16] "integer yresolution" [16]
LookAt 0 0 9  0 0 0  0 1 0
Camera "perspective" "float fov" [2]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material )") + c.material + R"(
Shape "disk"
)",
                                           Job(method, 255))
                              .image;
      EXPECT_TRUE(AllFinite(image)) << c.material << ' ' << method;
      test::Moments pixels;
      for (const Rgb pixel : image.pixels) pixels.Add(Luminance(pixel));
      const test::TestResult result = test::TTest(pixels, c.albedo, test::SidakLevel(0.01, 10 * 6), c.bias);
      EXPECT_TRUE(result.accepted) << c.material << ", " << method << ": " << result.message;
    }
  }
}

TEST(ExtremesTest, DegenerateAndDuplicateTrianglesZeroNormalsAndUvs) {
  for (const std::string& method : kMethods) {
    const test::Rendered rendered = test::RenderText(test::Room(R"(AreaLightSource "diffuse" "rgb L" [5 5 5]
Shape "disk" "float radius" [0.3] "float height" [-0.5]
Material "diffuse"
Shape "trianglemesh" "point3 P" [0 0 0  0 0 0  0 0 0  -0.5 0 0.2  0.5 0 0.2  0 0.5 0.2] "integer indices" [0 1 2  3 4 5  3 4 5  3 3 4]
  "normal N" [0 0 0  0 0 0  0 0 0  0 0 0  0 0 0  0 0 0] "point2 uv" [0 0  0 0  0 0  0 0  0 0  0 0]
)"),
                                                     Job(method, 7));
    EXPECT_TRUE(AllFinite(rendered.image)) << method;
    EXPECT_EQ(rendered.report.health.total(), 0u) << method;
    EXPECT_GT(Mean(rendered.image), 0) << method;
  }
}

}  // namespace
}  // namespace lodestar
