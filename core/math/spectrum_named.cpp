// Named spectra of pbrt-v4. Measured constants, with their sources:
//   Cu, Ag, Au: Johnson and Christy 1972. Al: Rakic 1995. CuZn (70/30 brass): Querry 1985.
//   MgO: Stephens and Malitson 1952 (dispersion formula; k is below 1e-6 in the visible and taken as 0).
//   TiO2 (rutile, ordinary ray): DeVore 1951 (dispersion formula; k likewise 0).
//   Glasses: Schott's Sellmeier coefficients. pbrt's names F5, F10 and F11 are Schott's SF5, SF10 and SF11.
//   Illuminants: chromaticities of CIE 15:2004 (2-degree observer) and of ACES' D60.
#include <cmath>
#include <span>

#include "core/math/spectrum.h"

namespace lodestar {
namespace {

struct NkRow {
  double nm, eta, k;
};

// clang-format off
constexpr NkRow kCu[] = {{367.9, 1.36, 1.975}, {381.5, 1.33, 2.045}, {397.4, 1.32, 2.116}, {413.3, 1.28, 2.207}, {430.5, 1.25, 2.305},
  {450.9, 1.24, 2.397}, {471.4, 1.25, 2.483}, {495.9, 1.22, 2.564}, {520.9, 1.18, 2.608}, {548.6, 1.02, 2.577}, {582.1, 0.70, 2.704},
  {616.8, 0.30, 3.205}, {659.5, 0.22, 3.747}, {704.5, 0.21, 4.205}, {756.0, 0.24, 4.665}, {821.1, 0.26, 5.180}};
constexpr NkRow kAg[] = {{367.9, 0.07, 1.657}, {381.5, 0.05, 1.864}, {397.4, 0.05, 2.070}, {413.3, 0.05, 2.275}, {430.5, 0.04, 2.462},
  {450.9, 0.04, 2.657}, {471.4, 0.05, 2.869}, {495.9, 0.05, 3.093}, {520.9, 0.05, 3.324}, {548.6, 0.06, 3.586}, {582.1, 0.05, 3.858},
  {616.8, 0.06, 4.152}, {659.5, 0.05, 4.483}, {704.5, 0.04, 4.838}, {756.0, 0.03, 5.242}, {821.1, 0.04, 5.727}};
constexpr NkRow kAu[] = {{367.9, 1.48, 1.895}, {381.5, 1.46, 1.933}, {397.4, 1.47, 1.952}, {413.3, 1.46, 1.958}, {430.5, 1.45, 1.948},
  {450.9, 1.38, 1.914}, {471.4, 1.31, 1.849}, {495.9, 1.04, 1.833}, {520.9, 0.62, 2.081}, {548.6, 0.43, 2.455}, {582.1, 0.29, 2.863},
  {616.8, 0.21, 3.272}, {659.5, 0.14, 3.697}, {704.5, 0.13, 4.103}, {756.0, 0.14, 4.542}, {821.1, 0.16, 5.083}};
constexpr NkRow kAl[] = {{364.66, 0.39877, 4.3957}, {413.28, 0.52135, 5.0008}, {442.80, 0.60790, 5.3676}, {476.87, 0.72780, 5.7781},
  {516.60, 0.87340, 6.2418}, {563.57, 1.0728, 6.7839}, {619.93, 1.3660, 7.4052}, {652.25, 1.5724, 7.7354}, {688.81, 1.8301, 8.0601},
  {729.32, 2.1606, 8.3565}, {774.91, 2.6154, 8.4914}, {794.78, 2.7675, 8.3866}};
constexpr NkRow kCuZn[] = {{370, 1.497, 1.818}, {390, 1.471, 1.813}, {410, 1.405, 1.794}, {420, 1.350, 1.786}, {430, 1.278, 1.784},
  {440, 1.191, 1.797}, {450, 1.094, 1.829}, {460, 0.994, 1.883}, {470, 0.900, 1.957}, {480, 0.816, 2.046}, {490, 0.745, 2.145},
  {500, 0.686, 2.250}, {510, 0.639, 2.358}, {520, 0.602, 2.464}, {530, 0.573, 2.568}, {540, 0.549, 2.668}, {550, 0.527, 2.765},
  {560, 0.505, 2.860}, {570, 0.484, 2.958}, {580, 0.468, 3.059}, {590, 0.460, 3.159}, {600, 0.450, 3.253}, {620, 0.449, 3.434},
  {640, 0.444, 3.609}, {660, 0.445, 3.778}, {680, 0.444, 3.943}, {700, 0.446, 4.106}, {720, 0.450, 4.266}, {740, 0.455, 4.424},
  {760, 0.458, 4.579}, {780, 0.464, 4.737}, {800, 0.473, 4.890}};

struct Metal {
  std::string_view eta_name, k_name;
  std::span<const NkRow> rows;
};
const Metal kMetals[] = {{"metal-Ag-eta", "metal-Ag-k", kAg}, {"metal-Al-eta", "metal-Al-k", kAl}, {"metal-Au-eta", "metal-Au-k", kAu},
                         {"metal-Cu-eta", "metal-Cu-k", kCu}, {"metal-CuZn-eta", "metal-CuZn-k", kCuZn}};

struct Glass {
  std::string_view name;
  double b[3], c[3];  // Sellmeier, wavelengths in micrometres
};
constexpr Glass kGlasses[] = {
  {"glass-BK7", {1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653}},
  {"glass-BAF10", {1.5851495, 0.143559385, 1.08521269}, {0.00926681282, 0.0424489805, 105.613573}},
  {"glass-FK51A", {0.971247817, 0.216901417, 0.904651666}, {0.00472301995, 0.0153575612, 168.68133}},
  {"glass-LASF9", {2.00029547, 0.298926886, 1.80691843}, {0.0121426017, 0.0538736236, 156.530829}},
  {"glass-F5", {1.46141885, 0.247713019, 0.949995832}, {0.0111826126, 0.0508594669, 112.041888}},
  {"glass-F10", {1.61625977, 0.259229334, 1.07762317}, {0.0127534559, 0.0581983954, 116.60768}},
  {"glass-F11", {1.73848403, 0.311168974, 1.17490871}, {0.0136068604, 0.0615960463, 121.922711}},
  {"glass-SF11", {1.73848403, 0.311168974, 1.17490871}, {0.0136068604, 0.0615960463, 121.922711}},
  {"glass-F2", {1.34533359, 0.209073176, 0.937357162}, {0.00997743871, 0.0470450767, 111.886764}}};

struct Illuminant {
  std::string_view name;
  double x, y;
};
constexpr Illuminant kIlluminants[] = {
  {"stdillum-A", 0.44758, 0.40745}, {"stdillum-D50", 0.34567, 0.35851}, {"stdillum-D65", 0.31272, 0.32903}, {"illum-acesD60", 0.32168, 0.33767},
  {"stdillum-F1", 0.31310, 0.33727}, {"stdillum-F2", 0.37208, 0.37529}, {"stdillum-F3", 0.40910, 0.39430}, {"stdillum-F4", 0.44018, 0.40329},
  {"stdillum-F5", 0.31379, 0.34531}, {"stdillum-F6", 0.37790, 0.38835}, {"stdillum-F7", 0.31292, 0.32933}, {"stdillum-F8", 0.34588, 0.35875},
  {"stdillum-F9", 0.37417, 0.37281}, {"stdillum-F10", 0.34609, 0.35986}, {"stdillum-F11", 0.38052, 0.37713}, {"stdillum-F12", 0.43695, 0.40441}};
// clang-format on

Rgb TableToRgb(std::span<const NkRow> rows, bool k) {
  SampledSpectrum spectrum;
  for (const NkRow& row : rows) {
    spectrum.wavelengths.push_back(row.nm);
    spectrum.values.push_back(k ? row.k : row.eta);
  }
  return SurfaceSpectrumToRgb(spectrum);
}

template <class Formula>
Rgb FormulaToRgb(Formula eta_squared) {
  SampledSpectrum spectrum;
  for (int nm = 380; nm <= 780; nm += 10) {
    spectrum.wavelengths.push_back(nm);
    spectrum.values.push_back(std::sqrt(eta_squared(nm * nm * 1e-6)));
  }
  return SurfaceSpectrumToRgb(spectrum);
}

}  // namespace

std::optional<Rgb> NamedSurfaceSpectrum(std::string_view name) {
  for (const Metal& metal : kMetals)
    if (name == metal.eta_name || name == metal.k_name) return TableToRgb(metal.rows, name == metal.k_name);
  if (name == "metal-MgO-eta")
    return FormulaToRgb(
        [](double l2) { return 2.956362 - 0.01062387 * l2 - 0.0000204968 * l2 * l2 + 0.02195770 / (l2 - 0.01428322); });
  if (name == "metal-TiO2-eta") return FormulaToRgb([](double l2) { return 5.913 + 0.2441 / (l2 - 0.0803); });
  if (name == "metal-MgO-k" || name == "metal-TiO2-k") return Rgb(0);
  return std::nullopt;
}

std::optional<double> NamedGlassEta(std::string_view name) {
  constexpr double kD = 0.5875618 * 0.5875618;  // helium d line, micrometres squared
  for (const Glass& glass : kGlasses) {
    if (name != glass.name) continue;
    double eta_squared = 1;
    for (int i = 0; i < 3; ++i) eta_squared += glass.b[i] * kD / (kD - glass.c[i]);
    return std::sqrt(eta_squared);
  }
  return std::nullopt;
}

std::optional<Rgb> NamedIlluminant(std::string_view name) {
  if (name == "stdillum-D65") return Rgb(1);  // the white of the colour space itself
  for (const Illuminant& illuminant : kIlluminants)
    if (name == illuminant.name) return ChromaticityToUnitRgb(illuminant.x, illuminant.y);
  return std::nullopt;
}

std::vector<std::string_view> NamedSpectra() {
  std::vector<std::string_view> names;
  for (const Metal& metal : kMetals) names.insert(names.end(), {metal.eta_name, metal.k_name});
  names.insert(names.end(), {"metal-MgO-eta", "metal-MgO-k", "metal-TiO2-eta", "metal-TiO2-k"});
  for (const Glass& glass : kGlasses) names.push_back(glass.name);
  for (const Illuminant& illuminant : kIlluminants) names.push_back(illuminant.name);
  return names;
}

}  // namespace lodestar
