#include <cmath>

#include "core/math/spectrum.h"
#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

template <class Kind>
Kind Made(const std::string& text) {
  return Get<Kind>(ParseWorld("LightSource " + text).lights.at(0).kind);
}
AreaLightDescription Area(const std::string& params) {
  return ParseWorld("AreaLightSource \"diffuse\" " + params + " Shape \"sphere\"").shapes.at(0).light.value();
}

TEST(PbrtLights, AreaLight) {
  const auto plain = Area("");
  EXPECT_EQ(plain.radiance, Rgb(1));
  EXPECT_FALSE(plain.two_sided);
  EXPECT_EQ(plain.power, 0);
  EXPECT_EQ(plain.where.ToString(), "s.pbrt:2:1");
  EXPECT_EQ(Area("\"rgb L\" [1 2 3] \"float scale\" 2").radiance, Rgb(2, 4, 6));
  EXPECT_EQ(Area("\"rgbs L\" [1 2 3]").radiance, Rgb(1, 2, 3));
  EXPECT_TRUE(Area("\"bool twosided\" true").two_sided);
  EXPECT_EQ(Area("\"float power\" 100").power, 100);
  EXPECT_EQ(Area("\"float power\" 100 \"float scale\" .5").power, 50);
  EXPECT_EQ(Area("\"float power\" 100 \"float scale\" .5 \"rgb L\" [1 2 3]").radiance, Rgb(1, 2, 3));
}

TEST(PbrtLights, SpectraOtherThanRgbHaveUnitLuminance) {
  ExpectRgb(Area("\"blackbody L\" 3000 \"float scale\" 5").radiance, BlackbodyToUnitRgb(3000) * 5);
  EXPECT_EQ(Area("\"spectrum L\" \"stdillum-D65\"").radiance, Rgb(1));
  ExpectRgb(Area("\"spectrum L\" [300 7 900 7]").radiance, EmissionToUnitRgb({{300, 900}, {1, 1}}), 1e-5f);
  EXPECT_NEAR(Luminance(Area("\"spectrum L\" \"light.spd\"").radiance), 1, 1e-5);
  EXPECT_EQ(ParseWorld("LightSource \"infinite\" \"spectrum L\" \"light.spd\"").files.size(), 1u);
  EXPECT_NEAR(Luminance(Made<PointLight>("\"point\" \"blackbody I\" 6500").intensity), 1, 1e-5);
}

TEST(PbrtLights, Point) {
  const auto plain = Made<PointLight>("\"point\"");
  EXPECT_EQ(plain.intensity, Rgb(1));
  EXPECT_EQ(plain.from, (Vec3{0, 0, 0}));
  EXPECT_EQ(Made<PointLight>("\"point\" \"rgb I\" [1 2 3] \"float scale\" 2").intensity, Rgb(2, 4, 6));
  // All of the power, over the whole sphere. As in pbrt-v4 an rgb multiplies it; any other spectrum has luminance 1.
  ExpectRgb(Made<PointLight>("\"point\" \"float power\" 60 \"rgb I\" [3 1 2]").intensity,
            Rgb(3, 1, 2) * (60 / (4 * kPi)), 1e-4f);
  EXPECT_NEAR(4 * kPi * Luminance(Made<PointLight>("\"point\" \"float power\" 60 \"blackbody I\" 3000").intensity), 60,
              1e-3);
  const auto moved = ParseWorld("Translate 1 2 3 LightSource \"point\" \"point3 from\" [1 1 1]");
  EXPECT_EQ(Get<PointLight>(moved.lights.at(0).kind).from, (Vec3{2, 3, 4}));
  EXPECT_EQ(moved.lights[0].world_from_light.Point({0, 0, 0}), (Vec3{1, 2, 3}));
}

TEST(PbrtLights, Spot) {
  const auto plain = Made<SpotLight>("\"spot\"");
  EXPECT_EQ(plain.from, (Vec3{0, 0, 0}));
  EXPECT_EQ(plain.to, (Vec3{0, 0, 1}));
  EXPECT_EQ(plain.cone_angle, 30);
  EXPECT_EQ(plain.cone_delta, 5);
  const auto spot = Get<SpotLight>(
      ParseWorld("Scale 2 2 2 LightSource \"spot\" \"point3 from\" [1 0 0] \"point3 to\" [1 1 0] \"float coneangle\" "
                 "60 \"float conedeltaangle\" 60 \"rgb I\" [1 0 0] \"float scale\" 3")
          .lights.at(0)
          .kind);
  EXPECT_EQ(spot.from, (Vec3{2, 0, 0}));
  EXPECT_EQ(spot.to, (Vec3{2, 2, 0}));
  EXPECT_EQ(spot.cone_angle, 60);
  EXPECT_EQ(spot.cone_delta, 60);
  EXPECT_EQ(spot.intensity, Rgb(3, 0, 0));
  // The smooth step t^2 (3 - 2 t) in the cosine, integrated numerically.
  const auto power = Made<SpotLight>("\"spot\" \"float power\" 10 \"float coneangle\" 50 \"float conedeltaangle\" 20");
  const double edge = std::cos(50 * kPi / 180), full = std::cos(30 * kPi / 180);
  double integral = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double c = edge + (1 - edge) * (i + 0.5) / kSteps, t = std::min((c - edge) / (full - edge), 1.0);
    integral += t * t * (3 - 2 * t) * (1 - edge) / kSteps;
  }
  EXPECT_NEAR(power.intensity.g * 2 * kPi * integral, 10, 1e-3);
}

TEST(PbrtLights, Distant) {
  const auto plain = Made<DistantLight>("\"distant\"");
  EXPECT_EQ(plain.to_light, (Vec3{0, 0, -1}));
  EXPECT_EQ(plain.radiance, Rgb(1));
  const auto sun = Get<DistantLight>(ParseWorld("Rotate 90 1 0 0 LightSource \"distant\" \"point3 from\" [0 0 5] "
                                                "\"point3 to\" [0 0 1] \"blackbody L\" 5000 \"float scale\" 2")
                                         .lights.at(0)
                                         .kind);
  EXPECT_NEAR(sun.to_light.y, -1, 1e-6);
  EXPECT_NEAR(Luminance(sun.radiance), 2, 1e-5);
  ExpectRgb(Made<DistantLight>("\"distant\" \"float illuminance\" 1000 \"rgb L\" [4 2 1]").radiance,
            Rgb(4000, 2000, 1000), 1e-2f);
}

TEST(PbrtLights, Infinite) {
  EXPECT_EQ(Made<InfiniteLight>("\"infinite\"").radiance, Rgb(1));
  EXPECT_EQ(Made<InfiniteLight>("\"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2").radiance, Rgb(2, 4, 6));
  EXPECT_NEAR(Luminance(Made<InfiniteLight>("\"infinite\" \"float illuminance\" 10").radiance) * kPi, 10, 1e-4);
  const auto scene =
      ParseWorld("Rotate 90 0 0 1 LightSource \"infinite\" \"string filename\" \"image.png\" \"float scale\" 3");
  const auto sky = Get<InfiniteLight>(scene.lights.at(0).kind);
  EXPECT_EQ(sky.path, (Folder() / "image.png").string());
  EXPECT_EQ(sky.radiance, Rgb(3));
  EXPECT_EQ(sky.illuminance, 0);
  EXPECT_EQ(Made<InfiniteLight>("\"infinite\" \"string filename\" \"image.png\" \"float illuminance\" 7").illuminance,
            7);
  EXPECT_NEAR(scene.lights[0].world_from_light.Vector({1, 0, 0}).y, 1, 1e-6);
}

// Lenient leaves out the light, not the shape; what is wholly there or wholly absent emits.
TEST(PbrtLights, ASphereEmitsUnlessItIsPartlyThere) {
  const std::string light = "AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" ";
  EXPECT_FALSE(ParseWorld(light + ".5", true).shapes.at(0).light);
  EXPECT_TRUE(ParseWorld(light + "0").shapes.at(0).light);
  EXPECT_TRUE(ParseWorld(light + "1").shapes.at(0).light);
  EXPECT_TRUE(ParseWorld("Texture \"one\" \"float\" \"constant\" AreaLightSource \"diffuse\" Shape \"disk\" "
                         "\"texture alpha\" \"one\"")
                  .shapes.at(0)
                  .light);
  EXPECT_TRUE(ParseWorld("Texture \"image\" \"float\" \"imagemap\" \"string filename\" \"image.png\" "
                         "AreaLightSource \"diffuse\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] "
                         "\"texture alpha\" \"image\"")
                  .shapes.at(0)
                  .light);
}

TEST(PbrtLights, RefusesByNameAndPlace) {
  const Refused cases[] = {
      {"AreaLightSource \"area\"", kBad, "2:1", "supported here: diffuse"},
      {"AreaLightSource \"diffuse\" \"string filename\" \"image.png\"", kNo, "2:27", "light from an image"},
      {"AreaLightSource \"diffuse\" \"float L\" 1", kBad, "2:27",
       "expected \"rgb L\" or \"spectrum L\" or \"blackbody L\""},
      {"AreaLightSource \"diffuse\" \"rgb L\" [1 -1 1]", kBad, "2:27", "negative"},
      {"AreaLightSource \"diffuse\" \"float scale\" -1", kBad, "2:27", "negative"},
      {"AreaLightSource \"diffuse\" \"float power\" 0", kBad, "2:27", "greater than 0"},
      {"AreaLightSource \"diffuse\" \"rgb L\" [0 0 0] \"float power\" 1", kBad, "2:43", "not black"},
      {"AreaLightSource \"diffuse\" \"integer samples\" 1", kBad, "2:27",
       "it takes: L, filename, power, scale, twosided"},
      {"AreaLightSource \"diffuse\" Material \"interface\" Shape \"sphere\"", kNo, "2:48",
       "no surface that could emit"},
      {"AreaLightSource \"diffuse\" NamedMaterial \"outer\" Shape \"sphere\" "
       "MakeNamedMaterial \"outer\" \"string type\" \"mix\" \"string materials\" [\"d\" \"inner\"] "
       "MakeNamedMaterial \"inner\" \"string type\" \"mix\" \"string materials\" [\"i\" \"d\"] "
       "MakeNamedMaterial \"d\" \"string type\" \"diffuse\" MakeNamedMaterial \"i\" \"string type\" \"interface\"",
       kNo, "2:49", "or of a mix with it"},
      {"AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" .5", kNo, "2:27", "scale its radiance"},
      {"AreaLightSource \"diffuse\" Shape \"disk\" \"float alpha\" .5", kNo, "2:27", "scale its radiance"},
      {"Texture \"half\" \"float\" \"constant\" \"float value\" .5 AreaLightSource \"diffuse\" "
       "Shape \"disk\" \"texture alpha\" \"half\"",
       kNo, "2:78", "scale its radiance"},
      {"Texture \"image\" \"float\" \"imagemap\" \"string filename\" \"image.png\" AreaLightSource \"diffuse\" "
       "Shape \"sphere\" \"texture alpha\" \"image\"",
       kNo, "2:92", "use a triangle mesh"},
      {"AreaLightSource \"diffuse\" \"bool twosided\" 1", kBad, "2:43", "true or false"},
      {"LightSource \"sun\"", kBad, "2:1", "supported here: point, spot"},
      {"LightSource \"goniometric\" \"string filename\" \"a\"", kNo, "2:1", "use point, spot"},
      {"LightSource \"projection\"", kNo, "2:1", "use point, spot"},
      {"LightSource \"point\" \"rgb L\" [1 1 1]", kBad, "2:21", "it takes: I, from, power, scale"},
      {"LightSource \"point\" \"point3 from\" [1 1]", kBad, "2:21", "three numbers"},
      {"LightSource \"point\" \"point3 from\" [1 1 1 2 2 2]", kBad, "2:21", "one point, not 2"},
      {"LightSource \"point\" \"vector3 from\" [1 1 1]", kBad, "2:21", "expected \"point3 from\""},
      {"LightSource \"point\" \"float power\" -1", kBad, "2:21", "greater than 0"},
      {"LightSource \"point\" \"rgb I\" [0 0 0] \"float power\" 1", kBad, "2:37", "not black"},
      {"LightSource \"point\" \"blackbody I\" 0", kBad, "2:21", "kelvin"},
      {"LightSource \"point\" \"blackbody I\" [3000 2]", kBad, "2:21", "one temperature"},
      {"LightSource \"point\" \"spectrum I\" \"metal-Cu-k\"", kMissing, "2:21", "named spectrum of this kind"},
      {"LightSource \"spot\" \"point3 to\" [0 0 0]", kBad, "2:1", "same point"},
      {"LightSource \"spot\" \"float coneangle\" 0", kBad, "2:20", "greater than 0"},
      {"LightSource \"spot\" \"float coneangle\" 181", kBad, "2:20", "180 degrees"},
      {"LightSource \"spot\" \"float conedeltaangle\" 31", kBad, "2:1", "must not exceed \"coneangle\""},
      {"LightSource \"spot\" \"float conedeltaangle\" -1", kBad, "2:20", "negative"},
      {"LightSource \"distant\" \"point3 from\" [0 0 1]", kBad, "2:1", "same point"},
      {"LightSource \"distant\" \"float illuminance\" 0", kBad, "2:23", "greater than 0"},
      {"LightSource \"distant\" \"float power\" 1", kBad, "2:23", "not used"},
      {"LightSource \"infinite\" \"string filename\" \"absent.exr\"", kMissing, "2:24", "absent.exr"},
      {"LightSource \"infinite\" \"string filename\" \"image.png\" \"rgb L\" [1 1 1]", kBad, "2:54",
       "cannot be combined"},
      {"LightSource \"infinite\" \"string filename\" \"image.png\" \"float illuminance\" 0", kBad, "2:54",
       "greater than 0"},
      {"LightSource \"infinite\" \"point3 portal\" [0 0 0 1 0 0 1 1 0 0 1 0]", kNo, "2:24", "whole environment"},
      {"ObjectBegin \"o\" LightSource \"point\" ObjectEnd", kNo, "2:17", "cannot be instanced"},
  };
  for (const Refused& c : cases) ExpectRefused(c, true);
}

}  // namespace
}  // namespace lodestar
