#include "core/math/spectrum.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/math/elementary.h"
#include "core/math/spectrum_tables.h"

namespace lodestar {
namespace {

// A table in even steps, linear in between (how the CIE defines its illuminants between tabulated wavelengths).
template <class Row, class Column>
double Interpolate(const Row* rows, double nm, Column column) {
  const double at = (nm - kCieFirstNm) / kCieStepNm;
  const int i = std::clamp(static_cast<int>(at), 0, kCieRows - 2);
  const double t = at - i;
  return (1 - t) * column(rows[i]) + t * column(rows[i + 1]);
}

Xyz ColourMatching(double nm) {
  return {Interpolate(kCieRowsTable, nm, [](const CieRow& r) { return r.x; }),
          Interpolate(kCieRowsTable, nm, [](const CieRow& r) { return r.y; }),
          Interpolate(kCieRowsTable, nm, [](const CieRow& r) { return r.z; })};
}
double D65(double nm) {
  return Interpolate(kCieRowsTable, nm, [](const CieRow& r) { return r.d65; });
}

// The sum of f(nm) * (xbar, ybar, zbar) in steps of 1 nm; the functions vanish at both ends, so the sum is the
// trapezoid rule.
template <class Function>
Xyz Integrate(Function f) {
  Xyz sum;
  for (int nm = kCieFirstNm; nm <= kCieLastNm; ++nm) {
    const Xyz bar = ColourMatching(nm);
    const double value = f(static_cast<double>(nm));
    sum.x += value * bar.x;
    sum.y += value * bar.y;
    sum.z += value * bar.z;
  }
  return sum;
}

struct LinearSrgb {
  double r, g, b;
};

// IEC 61966-2-1, D65 white.
LinearSrgb XyzToSrgb(Xyz c) {
  return {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z, -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
          0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

Rgb UnitLuminance(Xyz xyz) {
  // Dividing by the white of our own table first makes D65 exactly neutral.
  static const LinearSrgb white = XyzToSrgb(Integrate(D65));
  const LinearSrgb c = XyzToSrgb(xyz);
  const double r = std::max(c.r / white.r, 0.0), g = std::max(c.g / white.g, 0.0), b = std::max(c.b / white.b, 0.0);
  const double y = 0.212671 * r + 0.715160 * g + 0.072169 * b;
  if (!(y > 0)) return Rgb(0);
  return {static_cast<float>(r / y), static_cast<float>(g / y), static_cast<float>(b / y)};
}

}  // namespace

double SampledSpectrum::At(double nm) const {
  LODESTAR_CHECK(wavelengths.size() == values.size());
  if (wavelengths.empty() || nm < wavelengths.front() || nm > wavelengths.back()) return 0;
  const size_t hi = std::upper_bound(wavelengths.begin(), wavelengths.end(), nm) - wavelengths.begin();
  if (hi == wavelengths.size()) return values.back();
  const double t = (nm - wavelengths[hi - 1]) / (wavelengths[hi] - wavelengths[hi - 1]);
  return (1 - t) * values[hi - 1] + t * values[hi];
}

Xyz EmissionToXyz(const SampledSpectrum& spectrum) {
  static const double norm = Integrate([](double) { return 1.0; }).y;
  const Xyz sum = Integrate([&](double nm) { return spectrum.At(nm); });
  return {sum.x / norm, sum.y / norm, sum.z / norm};
}

Rgb SurfaceSpectrumToRgb(const SampledSpectrum& spectrum) {
  static const LinearSrgb white = XyzToSrgb(Integrate(D65));
  const LinearSrgb c = XyzToSrgb(Integrate([&](double nm) { return spectrum.At(nm) * D65(nm); }));
  return {static_cast<float>(std::max(c.r / white.r, 0.0)), static_cast<float>(std::max(c.g / white.g, 0.0)),
          static_cast<float>(std::max(c.b / white.b, 0.0))};
}

Rgb EmissionToUnitRgb(const SampledSpectrum& spectrum) {
  return UnitLuminance(EmissionToXyz(spectrum));
}

Rgb BlackbodyToUnitRgb(double kelvin) {
  LODESTAR_CHECK(kelvin > 0);
  constexpr double kSecondRadiation = 1.438776877e7;  // h c / k, nm K (CODATA 2018)
  // Relative to the longest wavelength, so that a cool body does not underflow: only the ratio between wavelengths
  // matters.
  const double x0 = kSecondRadiation / (kCieLastNm * kelvin);
  return UnitLuminance(Integrate([&](double nm) {
    const double x = kSecondRadiation / (nm * kelvin), s = nm / 560;
    const float numerator = Exp(static_cast<float>(x0 - x));
    // 1 - exp(-x) cancels for hot bodies, where its series is exact enough.
    const double denominator = x > 1e-3 ? 1.0 - Exp(static_cast<float>(-x)) : x * (1 - x / 2);
    return numerator / (denominator * s * s * s * s * s);
  }));
}

Rgb ChromaticityToUnitRgb(double x, double y) {
  LODESTAR_CHECK(y > 0);
  // Here the white is the standard's own (0.3127, 0.3290), through UnitLuminance's table white (equal to 4 digits).
  return UnitLuminance({x / y, 1, (1 - x - y) / y});
}

}  // namespace lodestar
