#include "core/math/spectrum.h"

#include <gtest/gtest.h>

#include "core/math/spectrum_tables.h"

namespace lodestar {
namespace {

SampledSpectrum Constant(double value) {
  return {{300, 900}, {value, value}};
}

void ExpectNear(Rgb actual, Rgb expected, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "component " << c;
}

TEST(SampledSpectrum, IsPiecewiseLinearAndZeroOutside) {
  const SampledSpectrum s{{400, 500, 700}, {1, 3, 5}};
  EXPECT_EQ(s.At(399), 0);
  EXPECT_EQ(s.At(400), 1);
  EXPECT_DOUBLE_EQ(s.At(450), 2);
  EXPECT_DOUBLE_EQ(s.At(600), 4);
  EXPECT_EQ(s.At(700), 5);
  EXPECT_EQ(s.At(701), 0);
  EXPECT_EQ(SampledSpectrum{}.At(500), 0);
}

TEST(Spectrum, ConstantEmissionHasLuminanceOneAndTheChromaticityOfE) {
  const Xyz e = EmissionToXyz(Constant(1));
  EXPECT_DOUBLE_EQ(e.y, 1);
  EXPECT_NEAR(e.x / (e.x + e.y + e.z), 1 / 3.0, 2e-4);
  EXPECT_NEAR(e.z / (e.x + e.y + e.z), 1 / 3.0, 2e-4);
}

// The published chromaticity of D65 checks the table of the observer and that of the illuminant at once.
TEST(Spectrum, TablesReproduceTheChromaticityOfD65) {
  SampledSpectrum d65;
  for (int i = 0; i < kCieRows; ++i) {
    d65.wavelengths.push_back(kCieFirstNm + i * kCieStepNm);
    d65.values.push_back(kCieRowsTable[i].d65);
  }
  const Xyz c = EmissionToXyz(d65);
  EXPECT_NEAR(c.x / (c.x + c.y + c.z), 0.31272, 5e-5);
  EXPECT_NEAR(c.y / (c.x + c.y + c.z), 0.32903, 5e-5);
  ExpectNear(EmissionToUnitRgb(d65), Rgb(1), 1e-5f);
}

TEST(Spectrum, ConstantSurfaceIsNeutral) {
  ExpectNear(SurfaceSpectrumToRgb(Constant(1)), Rgb(1), 1e-6f);
  ExpectNear(SurfaceSpectrumToRgb(Constant(0.18)), Rgb(0.18f), 1e-6f);
}

TEST(Spectrum, EmissionIsScaledToUnitLuminanceAndStaysNonNegative) {
  const Rgb red = EmissionToUnitRgb({{630, 640, 650}, {0, 7, 0}});
  EXPECT_GT(red.r, 3);
  EXPECT_EQ(red.g, 0);  // outside of the gamut
  EXPECT_NEAR(Luminance(red), 1, 1e-5);
  EXPECT_EQ(EmissionToUnitRgb(Constant(0)), Rgb(0));
  EXPECT_EQ(EmissionToUnitRgb({{100, 200}, {1, 1}}), Rgb(0));  // ultraviolet only
}

TEST(Spectrum, BlackbodyFollowsThePlanckianLocus) {
  // xy of the locus: 2856 K is illuminant A (0.4476, 0.4074); 6500 K is (0.3135, 0.3237).
  ExpectNear(BlackbodyToUnitRgb(2855.54), ChromaticityToUnitRgb(0.44758, 0.40745), 3e-3f);
  ExpectNear(BlackbodyToUnitRgb(6500), ChromaticityToUnitRgb(0.3135, 0.3237), 3e-3f);
  ExpectNear(BlackbodyToUnitRgb(6500), Rgb(1), 0.08f);
  EXPECT_GT(BlackbodyToUnitRgb(2000).r, 2);
  EXPECT_GT(BlackbodyToUnitRgb(20000).b, BlackbodyToUnitRgb(20000).r);
  for (double kelvin : {1.0, 50.0, 300.0, 1000.0, 1e4, 1e6, 1e9, 1e20}) {
    const Rgb c = BlackbodyToUnitRgb(kelvin);
    EXPECT_TRUE(IsFinite(c)) << kelvin;
    EXPECT_GE(MinComponent(c), 0) << kelvin;
    EXPECT_NEAR(Luminance(c), 1, 1e-4) << kelvin;
  }
}

float NormalReflectance(Rgb eta, Rgb k, int c) {
  return ((eta[c] - 1) * (eta[c] - 1) + k[c] * k[c]) / ((eta[c] + 1) * (eta[c] + 1) + k[c] * k[c]);
}

TEST(NamedSpectra, MetalsHaveTheirColours) {
  const Rgb eta = *NamedSurfaceSpectrum("metal-Cu-eta"), k = *NamedSurfaceSpectrum("metal-Cu-k");
  // The RGB values of copper that circulate, eta (0.200, 0.924, 1.102) and k (3.913, 2.453, 2.142), were integrated
  // against equal energy: divided by what that makes of a constant spectrum, (1.205, 0.948, 0.909), they are ours.
  ExpectNear(eta, {0.166f, 0.975f, 1.212f}, 0.1f);
  ExpectNear(k, {3.247f, 2.588f, 2.356f}, 0.1f);
  EXPECT_GT(NormalReflectance(eta, k, 0), 0.88f);
  EXPECT_NEAR(NormalReflectance(eta, k, 2), 0.52f, 0.06f);
  const Rgb gold_eta = *NamedSurfaceSpectrum("metal-Au-eta"), gold_k = *NamedSurfaceSpectrum("metal-Au-k");
  EXPECT_GT(NormalReflectance(gold_eta, gold_k, 0), NormalReflectance(gold_eta, gold_k, 1) + 0.1f);
  EXPECT_GT(NormalReflectance(gold_eta, gold_k, 1), NormalReflectance(gold_eta, gold_k, 2) + 0.2f);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(NormalReflectance(*NamedSurfaceSpectrum("metal-Ag-eta"), *NamedSurfaceSpectrum("metal-Ag-k"), c), 0.97f,
                0.02f);
    EXPECT_NEAR(NormalReflectance(*NamedSurfaceSpectrum("metal-Al-eta"), *NamedSurfaceSpectrum("metal-Al-k"), c),
                0.915f, 0.015f);
  }
  EXPECT_NEAR(NamedSurfaceSpectrum("metal-MgO-eta")->g, 1.7375f, 0.01f);
  EXPECT_NEAR(NamedSurfaceSpectrum("metal-TiO2-eta")->g, 2.65f, 0.05f);
}

TEST(NamedSpectra, GlassesHaveTheirCataloguedIndex) {
  const std::pair<const char*, double> catalogue[] = {
      {"glass-BK7", 1.51680},   {"glass-BAF10", 1.67003}, {"glass-FK51A", 1.48656},
      {"glass-LASF9", 1.85025}, {"glass-F5", 1.67270},    {"glass-F10", 1.72825},
      {"glass-F11", 1.78472},   {"glass-SF11", 1.78472},  {"glass-F2", 1.62004}};
  for (const auto& [name, eta] : catalogue) EXPECT_NEAR(NamedGlassEta(name).value(), eta, 2e-5) << name;
  EXPECT_FALSE(NamedGlassEta("metal-Cu-eta"));
}

TEST(NamedSpectra, EveryNameHasExactlyOneKind) {
  for (std::string_view name : NamedSpectra()) {
    const int kinds =
        NamedSurfaceSpectrum(name).has_value() + NamedGlassEta(name).has_value() + NamedIlluminant(name).has_value();
    EXPECT_EQ(kinds, 1) << name;
  }
  EXPECT_FALSE(NamedSurfaceSpectrum("metal-Unobtainium-eta"));
  EXPECT_FALSE(NamedIlluminant("stdillum-Z"));
  EXPECT_EQ(*NamedIlluminant("stdillum-D65"), Rgb(1));
  EXPECT_GT(NamedIlluminant("stdillum-A")->r, 1.5f);
}

}  // namespace
}  // namespace lodestar
