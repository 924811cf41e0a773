#include <cmath>

#include "core/math/spectrum.h"
#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

// Texture 0 is a spectrum texture "s", 1 a float texture "f".
const std::string kTextures = "Texture \"s\" \"spectrum\" \"constant\" Texture \"f\" \"float\" \"constant\"\n";

template <class Kind>
Kind Made(const std::string& text) {
  return Get<Kind>(ParseWorld(kTextures + "Material " + text).materials.back().kind);
}

TEST(PbrtMaterials, DefaultIsGreyDiffuse) {
  const auto scene = ParseWorld("Shape \"sphere\" Shape \"sphere\"");
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.shapes[0].material, 0);
  EXPECT_EQ(scene.shapes[1].material, 0);
  EXPECT_EQ(Get<DiffuseMaterial>(scene.materials[0].kind).reflectance.value, Rgb(0.5f));
}

TEST(PbrtMaterials, Diffuse) {
  EXPECT_EQ(Made<DiffuseMaterial>("\"diffuse\"").reflectance.value, Rgb(0.5f));
  EXPECT_EQ(Made<DiffuseMaterial>("\"diffuse\" \"rgb reflectance\" [.1 .2 .3]").reflectance.value,
            Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(Made<DiffuseMaterial>("\"diffuse\" \"texture reflectance\" \"s\"").reflectance.texture, 0);
  ExpectRgb(Made<DiffuseMaterial>("\"diffuse\" \"spectrum reflectance\" [200 .3 900 .3]").reflectance.value, Rgb(0.3f));
  EXPECT_GT(Made<DiffuseMaterial>("\"diffuse\" \"spectrum reflectance\" [380 0 590 0 620 1 780 1]").reflectance.value.r,
            0.7f);
}

TEST(PbrtMaterials, RoughnessIsRemappedToItsSquareRoot) {
  const auto smooth = Made<DielectricMaterial>("\"dielectric\"").roughness;
  EXPECT_EQ(smooth.u.value, 0);
  EXPECT_EQ(smooth.v.value, 0);
  EXPECT_TRUE(smooth.remap);
  const auto both = Made<DielectricMaterial>("\"dielectric\" \"float roughness\" .25").roughness;
  EXPECT_EQ(both.u.value, 0.5f);
  EXPECT_EQ(both.v.value, 0.5f);
  const auto own =
      Made<DielectricMaterial>("\"dielectric\" \"float roughness\" .25 \"float vroughness\" .01").roughness;
  EXPECT_EQ(own.u.value, 0.5f);
  EXPECT_FLOAT_EQ(own.v.value, 0.1f);
  const auto plain =
      Made<DielectricMaterial>(
          "\"dielectric\" \"float uroughness\" .25 \"float vroughness\" .5 \"bool remaproughness\" false")
          .roughness;
  EXPECT_EQ(plain.u.value, 0.25f);
  EXPECT_EQ(plain.v.value, 0.5f);
  EXPECT_FALSE(plain.remap);
  const auto textured =
      Made<DielectricMaterial>("\"dielectric\" \"texture roughness\" \"f\" \"float uroughness\" .25").roughness;
  EXPECT_EQ(textured.u.texture, -1);
  EXPECT_EQ(textured.u.value, 0.5f);
  EXPECT_EQ(textured.v.texture, 1);
  EXPECT_TRUE(textured.remap);
}

TEST(PbrtMaterials, RoughnessAboveOneIsOneWhereItIsLeftOut) {
  const auto scene = ParseWorld("Material \"dielectric\" \"float roughness\" 2 \"bool remaproughness\" false", true);
  const auto roughness = Get<DielectricMaterial>(scene.materials.back().kind).roughness;
  EXPECT_EQ(roughness.u.value, 1);
  EXPECT_EQ(roughness.v.value, 1);
  EXPECT_EQ(scene.left_out.size(), 1u);  // of both axes
  EXPECT_EQ(Made<DielectricMaterial>("\"dielectric\" \"float roughness\" 1").roughness.u.value, 1);
}

TEST(PbrtMaterials, Conductor) {
  const auto copper = Made<ConductorMaterial>("\"conductor\"");
  EXPECT_FALSE(copper.has_reflectance);
  EXPECT_EQ(copper.eta.value, *NamedSurfaceSpectrum("metal-Cu-eta"));
  EXPECT_EQ(copper.k.value, *NamedSurfaceSpectrum("metal-Cu-k"));
  const auto gold = Made<ConductorMaterial>(
      "\"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float roughness\" .04");
  EXPECT_EQ(gold.eta.value, *NamedSurfaceSpectrum("metal-Au-eta"));
  EXPECT_FLOAT_EQ(gold.roughness.u.value, 0.2f);
  const auto rgb = Made<ConductorMaterial>("\"conductor\" \"rgb eta\" [1.6 .9 .5] \"rgb k\" [9 6 5]");
  EXPECT_EQ(rgb.eta.value, Rgb(1.6f, 0.9f, 0.5f));
  EXPECT_EQ(rgb.k.value, Rgb(9, 6, 5));
  const auto mirror = Made<ConductorMaterial>("\"conductor\" \"rgb reflectance\" [.9 .8 .7]");
  EXPECT_TRUE(mirror.has_reflectance);
  EXPECT_EQ(mirror.reflectance.value, Rgb(0.9f, 0.8f, 0.7f));
  EXPECT_EQ(Made<ConductorMaterial>("\"conductor\" \"texture eta\" \"s\"").eta.texture, 0);
}

TEST(PbrtMaterials, Dielectrics) {
  EXPECT_EQ(Made<DielectricMaterial>("\"dielectric\"").eta, 1.5f);
  EXPECT_EQ(Made<DielectricMaterial>("\"dielectric\" \"float eta\" 1.33").eta, 1.33f);
  EXPECT_NEAR(Made<DielectricMaterial>("\"dielectric\" \"spectrum eta\" \"glass-BK7\"").eta, 1.5168f, 1e-4f);
  EXPECT_NEAR(Made<DielectricMaterial>("\"dielectric\" \"spectrum eta\" [400 1 800 2]").eta, 1.4689f, 1e-4f);
  EXPECT_EQ(Made<ThinDielectricMaterial>("\"thindielectric\"").eta, 1.5f);
  EXPECT_NEAR(Made<ThinDielectricMaterial>("\"thindielectric\" \"spectrum eta\" \"glass-F11\"").eta, 1.78472f, 1e-4f);
}

TEST(PbrtMaterials, Coated) {
  const auto plain = Made<CoatedDiffuseMaterial>("\"coateddiffuse\"");
  EXPECT_EQ(plain.reflectance.value, Rgb(0.5f));
  EXPECT_EQ(plain.eta, 1.5f);
  EXPECT_EQ(plain.roughness.u.value, 0);
  const auto coated = Made<CoatedDiffuseMaterial>(
      "\"coateddiffuse\" \"texture reflectance\" \"s\" \"float eta\" 1.3 \"float roughness\" .09 \"float thickness\" "
      ".01 \"integer maxdepth\" 5 \"integer nsamples\" 2 \"float g\" .1 \"rgb albedo\" [0 0 0]");
  EXPECT_EQ(coated.reflectance.texture, 0);
  EXPECT_EQ(coated.eta, 1.3f);
  EXPECT_FLOAT_EQ(coated.roughness.v.value, 0.3f);
  const auto copper = Made<CoatedConductorMaterial>("\"coatedconductor\"");
  EXPECT_EQ(copper.interface_eta, 1.5f);
  EXPECT_EQ(copper.interface_roughness.u.value, 0);
  EXPECT_EQ(copper.conductor.eta.value, *NamedSurfaceSpectrum("metal-Cu-eta"));
  EXPECT_EQ(copper.conductor.roughness.u.value, 0);
  const auto metal = Made<CoatedConductorMaterial>(
      "\"coatedconductor\" \"float interface.roughness\" .01 \"float interface.eta\" 1.4 \"spectrum conductor.eta\" "
      "\"metal-Al-eta\" \"spectrum conductor.k\" \"metal-Al-k\" \"float conductor.uroughness\" .04"
      " \"float conductor.vroughness\" .09 \"float interface.thickness\" .01 \"integer maxdepth\" 5 \"integer "
      "nsamples\" "
      "2 \"float g\" 0");
  EXPECT_EQ(metal.interface_eta, 1.4f);
  EXPECT_FLOAT_EQ(metal.interface_roughness.v.value, 0.1f);
  EXPECT_EQ(metal.conductor.k.value, *NamedSurfaceSpectrum("metal-Al-k"));
  EXPECT_FLOAT_EQ(metal.conductor.roughness.u.value, 0.2f);
  EXPECT_FLOAT_EQ(metal.conductor.roughness.v.value, 0.3f);
  const auto rough = Made<CoatedConductorMaterial>(
      "\"coatedconductor\" \"float conductor.roughness\" .16 \"float conductor.vroughness\" .09");
  EXPECT_FLOAT_EQ(rough.conductor.roughness.u.value, 0.4f);
  EXPECT_FLOAT_EQ(rough.conductor.roughness.v.value, 0.3f);
  EXPECT_EQ(rough.interface_roughness.u.value, 0);
  EXPECT_TRUE(
      Made<CoatedConductorMaterial>("\"coatedconductor\" \"rgb reflectance\" [.5 .5 .5] \"float interface.uroughness\" "
                                    ".1 \"float interface.vroughness\" .1 \"float thickness\" .01")
          .conductor.has_reflectance);
}

TEST(PbrtMaterials, DiffuseTransmission) {
  const auto plain = Made<DiffuseTransmissionMaterial>("\"diffusetransmission\"");
  EXPECT_EQ(plain.reflectance.value, Rgb(0.25f));
  EXPECT_EQ(plain.transmittance.value, Rgb(0.25f));
  EXPECT_EQ(plain.scale, 1);
  const auto leaf = Made<DiffuseTransmissionMaterial>(
      "\"diffusetransmission\" \"rgb reflectance\" [.1 .2 .1] \"texture transmittance\" \"s\" \"float scale\" .5");
  EXPECT_EQ(leaf.reflectance.value, Rgb(0.1f, 0.2f, 0.1f));
  EXPECT_EQ(leaf.transmittance.texture, 0);
  EXPECT_EQ(leaf.scale, 0.5f);
  Made<DiffuseTransmissionMaterial>("\"diffusetransmission\" \"bool remaproughness\" false");  // read by pbrt-v4
}

TEST(PbrtMaterials, InterfaceHasTwoOlderNames) {
  for (const char* name : {"interface", "none", ""}) Made<InterfaceMaterial>('"' + std::string(name) + '"');
  const auto scene = ParseWorld("MakeNamedMaterial \"m\" \"string type\" \"none\"");
  EXPECT_TRUE(std::holds_alternative<InterfaceMaterial>(scene.materials.back().kind));
}

TEST(PbrtMaterials, NamesMayBeUsedBeforeTheyAreDefined) {
  const auto scene = ParseWorld(
      "NamedMaterial \"m\" Shape \"sphere\" Material \"mix\" \"string materials\" [\"a\" \"m\"] \"float amount\" .3 "
      "Shape \"sphere\""
      " MakeNamedMaterial \"m\" \"string type\" \"interface\" MakeNamedMaterial \"a\" \"string type\" \"dielectric\" "
      "\"float eta\" 2");
  const auto& named = scene.materials[scene.shapes.at(0).material];
  EXPECT_EQ(named.name, "m");
  EXPECT_TRUE(std::holds_alternative<InterfaceMaterial>(named.kind));
  const auto mix = Get<MixMaterial>(scene.materials[scene.shapes.at(1).material].kind);
  EXPECT_EQ(Get<DielectricMaterial>(scene.materials[mix.a].kind).eta, 2);
  EXPECT_EQ(mix.b, scene.shapes[0].material);
  EXPECT_EQ(mix.amount.value, 0.3f);
}

TEST(PbrtMaterials, MixesNestAndTakeTextures) {
  const auto scene = ParseWorld(
      kTextures +
      "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string "
      "materials\" [\"a\" \"a\"]"
      " MakeNamedMaterial \"n\" \"string type\" \"mix\" \"string materials\" [\"m\" \"a\"] \"texture amount\" \"f\"");
  EXPECT_EQ(Get<MixMaterial>(scene.materials.at(1).kind).amount.value, 0.5f);
  EXPECT_EQ(Get<MixMaterial>(scene.materials.at(2).kind).amount.texture, 1);
  EXPECT_EQ(Get<MixMaterial>(scene.materials.at(2).kind).a, 1);
}

TEST(PbrtMaterials, RefusesByNameAndPlace) {
  const Refused cases[] = {
      {"Material \"matte\"", kBad, "2:1", "supported here: diffuse, conductor"},
      {"Material \"subsurface\"", kNo, "2:1", "is not supported; use one of: diffuse"},
      {"Material \"hair\" \"float eumelanin\" 1", kNo, "2:1", "is not supported"},
      {"Material \"measured\" \"string filename\" \"x\"", kNo, "2:1", "is not supported"},
      {"Material \"diffuse\" \"float sigma\" 20", kBad, "2:20", "not used; it takes: "},
      {"Material \"diffuse\" \"rgb Kd\" [1 1 1]", kBad, "2:20", "not used; it takes: "},
      {"Material \"diffuse\" \"float reflectance\" 1", kBad, "2:20",
       "expected \"rgb reflectance\" or \"spectrum reflectance\" or \"texture reflectance\""},
      {"Material \"diffuse\" \"blackbody reflectance\" 3000", kBad, "2:20", "expected \"rgb reflectance\""},
      {"Material \"diffuse\" \"rgb reflectance\" [1 1]", kBad, "2:20", "three numbers, not 2"},
      {"Material \"diffuse\" \"rgb reflectance\" [1 -1 1]", kBad, "2:20", "negative"},
      {"Material \"diffuse\" \"rgb reflectance\" [1 1.5 1]", kBad, "2:20", "must not exceed 1"},
      {"Material \"diffuse\" \"spectrum reflectance\" [400 2 700 2]", kBad, "2:20", "must not exceed 1"},
      {"Material \"diffuse\" \"spectrum reflectance\" [400 .1 700]", kBad, "2:20", "pairs"},
      {"Material \"diffuse\" \"spectrum reflectance\" [700 .1 400 .2]", kBad, "2:20", "ascending"},
      {"Material \"diffuse\" \"spectrum reflectance\" [400 -.1 700 .2]", kBad, "2:20", "negative"},
      {"Material \"diffuse\" \"spectrum reflectance\" []", kBad, "2:20", "0 numbers"},
      {"Material \"diffuse\" \"spectrum reflectance\" \"nosuch\"", kMissing, "2:20", "metal-Ag-eta"},
      {"Material \"diffuse\" \"spectrum reflectance\" \"stdillum-A\"", kMissing, "2:20", "named spectrum of this kind"},
      {"Material \"diffuse\" \"spectrum reflectance\" [\"a\" \"b\"]", kBad, "2:20", "one name"},
      {"Material \"diffuse\" \"spectrum reflectance\" \"broken.spd\"", kBad, "2:20", "there are 3 numbers"},
      {"Material \"diffuse\" \"spectrum reflectance\" \"metal-Ag-k\"", kBad, "2:20", "must not exceed 1"},
      {"Material \"diffuse\" \"texture reflectance\" \"nowhere\"", kBad, "2:20", "no spectrum texture of that name"},
      {"Material \"diffuse\" \"bool remaproughness\" true", kBad, "2:20", "no roughness"},
      {"Material \"diffuse\" \"texture displacement\" \"d\"", kNo, "2:20", "as their geometry is"},
      {"Material \"diffuse\" \"string normalmap\" \"n.png\"", kNo, "2:20", "as their geometry is"},
      {"Material \"conductor\" \"texture displacement\" \"d\"", kNo, "2:22", "as their geometry is"},
      {"Material \"dielectric\" \"string normalmap\" \"n.png\"", kNo, "2:23", "as their geometry is"},
      {"Material \"thindielectric\" \"string normalmap\" \"n.png\"", kNo, "2:27", "as their geometry is"},
      {"Material \"coateddiffuse\" \"string normalmap\" \"n.png\"", kNo, "2:26", "as their geometry is"},
      {"Material \"coatedconductor\" \"string normalmap\" \"n.png\"", kNo, "2:28", "as their geometry is"},
      {"Material \"diffusetransmission\" \"texture displacement\" \"d\"", kNo, "2:32", "as their geometry is"},
      {"Material \"interface\" \"string normalmap\" \"n.png\"", kBad, "2:22", "not used"},
      {"Material \"none\" \"string normalmap\" \"n.png\"", kBad, "2:17", "not used"},
      {"Material \"conductor\" \"rgb reflectance\" [1 1 1] \"rgb eta\" [1 1 1]", kBad, "2:48", "cannot be combined"},
      {"Material \"conductor\" \"rgb k\" [1 1 1] \"rgb reflectance\" [1 1 1]", kBad, "2:22", "cannot be combined"},
      {"Material \"conductor\" \"float eta\" 1.5", kBad, "2:22", "expected \"rgb eta\""},
      {"Material \"conductor\" \"float roughness\" -1", kBad, "2:22", "must not be negative"},
      {"Material \"conductor\" \"float uroughness\" -1", kBad, "2:22", "must not be negative"},
      {"Material \"conductor\" \"float roughness\" 1.5", kNo, "2:22", "roughness ends at 1"},
      {"Material \"dielectric\" \"float roughness\" 1 \"float vroughness\" 2", kNo, "2:43", "\"float vroughness\""},
      {"Material \"coateddiffuse\" \"bool remaproughness\" false \"float uroughness\" 1.01", kNo, "2:54",
       "is not supported"},
      {"Material \"coatedconductor\" \"float interface.roughness\" 2", kNo, "2:28", "\"float interface.roughness\""},
      {"Material \"coatedconductor\" \"float conductor.roughness\" 2", kNo, "2:28", "\"float conductor.roughness\""},
      {"Material \"coatedconductor\" \"float conductor.vroughness\" 2", kNo, "2:28", "\"float conductor.vroughness\""},
      {"Material \"conductor\" \"rgb roughness\" [1 1 1]", kBad, "2:22", "expected \"float roughness\""},
      {"Material \"dielectric\" \"float eta\" 0", kBad, "2:23", "greater than 0"},
      {"Material \"dielectric\" \"rgb eta\" [1 1 1]", kBad, "2:23", "expected \"float eta\""},
      {"Material \"dielectric\" \"spectrum eta\" \"glass-XY\"", kMissing, "2:23", "glass-BK7"},
      {"Material \"dielectric\" \"spectrum eta\" [700 1.5 800 1.5]", kBad, "2:23", "at 587.6 nm"},
      {"Material \"thindielectric\" \"float roughness\" .1", kBad, "2:27", "not used"},
      {"Material \"coateddiffuse\" \"rgb albedo\" [.1 0 0]", kNo, "2:26", "only 0 is"},
      {"Material \"coatedconductor\" \"rgb albedo\" [.1 0 0]", kNo, "2:28", "only 0 is"},
      {"Material \"coateddiffuse\" \"float interface.roughness\" .1", kBad, "2:26", "not used"},
      {"Material \"diffusetransmission\" \"float scale\" -1", kBad, "2:32", "negative"},
      {"Material \"mix\"", kBad, "2:1", "\"string materials\""},
      {"Material \"mix\" \"string materials\" \"a\"", kBad, "2:16", "two names, not 1"},
      {"Material \"mix\" \"string materials\" [\"a\" \"b\"]", kBad, "2:16", "no MakeNamedMaterial defines it"},
      {"MakeNamedMaterial \"a\" \"string type\" \"interface\" Material \"mix\" \"string materials\" [\"a\" \"a\"] "
       "\"float amount\" 2",
       kBad, "2:93", "between 0 and 1"},
      {"MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"]", kBad, "2:1",
       "contains itself"},
      {"MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"b\" \"b\"] MakeNamedMaterial \"b\" "
       "\"string type\" \"mix\" \"string materials\" [\"b\" \"a\"]",
       kBad, "2:72", "contains itself"},
      {"NamedMaterial \"m\"", kBad, "2:1", "material \"m\" is used"},
      {"MakeNamedMaterial \"m\"", kBad, "2:1", "needs a \"string type\""},
      {"MakeNamedMaterial \"m\" \"string type\" \"\"", kBad, "2:1", "needs a \"string type\""},
      {"MakeNamedMaterial \"m\" \"string type\" \"glass\"", kBad, "2:1", "supported here: diffuse"},
      {"MakeNamedMaterial \"m\" \"string type\" \"diffuse\" MakeNamedMaterial \"m\" \"string type\" \"diffuse\"", kBad,
       "2:47", "defined already, at s.pbrt:2:1"},
  };
  for (const Refused& c : cases) ExpectRefused(c, true);
}

}  // namespace
}  // namespace lodestar
