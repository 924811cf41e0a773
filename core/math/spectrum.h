// Spectra to linear sRGB, once, while a scene is parsed: the renderer itself is RGB. Integration is against the CIE
// 1931 2-degree colour-matching functions in steps of 1 nm. Only elementary.h is used, so the result does not depend on
// the machine.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/math/rgb.h"

namespace lodestar {

// Piecewise linear over wavelengths in nm, ascending; zero outside of them.
struct SampledSpectrum {
  std::vector<double> wavelengths, values;
  double At(double nm) const;
};

struct Xyz {
  double x = 0, y = 0, z = 0;
};

// CIE XYZ of an emission spectrum; the constant 1 has Y = 1.
Xyz EmissionToXyz(const SampledSpectrum& spectrum);

// A reflectance, or any other quantity that a surface has by wavelength (eta, k): weighted with the white point of sRGB
// (D65), so that a constant c is (c, c, c). Components below zero (saturated colours outside of the gamut) become zero.
Rgb SurfaceSpectrumToRgb(const SampledSpectrum& spectrum);

// Emission, scaled to the luminance 1 as pbrt-v4 does for lights: the shape of the spectrum is its colour and the
// light's "scale" or "power" its strength. D65 is (1, 1, 1). Out-of-gamut components become zero before scaling; black
// stays black.
Rgb EmissionToUnitRgb(const SampledSpectrum& spectrum);
Rgb BlackbodyToUnitRgb(double kelvin);          // Planck's law, kelvin > 0
Rgb ChromaticityToUnitRgb(double x, double y);  // CIE 1931 xy, y > 0

// Named data of pbrt-v4 (spectrum_named.cpp has the sources). Nothing where the name is of another kind or unknown.
std::optional<Rgb> NamedSurfaceSpectrum(std::string_view name);  // metal-{Ag,Al,Au,Cu,CuZn,MgO,TiO2}-{eta,k}
std::optional<double> NamedGlassEta(std::string_view name);  // glass-{BK7,...}: index at 587.6 nm (the helium d line)
std::optional<Rgb> NamedIlluminant(std::string_view name);   // stdillum-*, illum-acesD60, of luminance 1
std::vector<std::string_view> NamedSpectra();                // all names, for messages

}  // namespace lodestar
