// What a dielectric coat lets through, tabulated: the quantities from which the coated materials are composed
// analytically (bsdf_coated.cpp).
//
// A coat is a flat or GGX-rough dielectric interface over an empty, lossless layer.
#pragma once

#include <algorithm>
#include <array>

#include "core/math/vec.h"

namespace lodestar {

// Tables over (mu, alpha) of one coat, alpha isotropic: alpha = (row / (kAlphas - 1))^2, row 0 the flat interface;
// linear in mu and alpha^2 between nodes.
class CoatTable {
 public:
  static constexpr int kMus = 128, kAlphas = 32, kBaseMus = 64, kCaps = 128;
  struct Row {
    int index;  // <= kAlphas - 2
    float t;
  };
  static Row RowOf(float alpha);

  // The table of a coat: computed at first use (about 50 ms) and kept for the life of the process; any thread. Later
  // calls take no lock.
  static const CoatTable& For(float eta);

  // 1 - E(mu), E the directional albedo of the coat's own reflection lobe (single scattering, dielectric Fresnel): what
  // that lobe leaves of the flux arriving from outside at mu. It counts light that a rough interface would scatter more
  // than once as let through, so that lobe and remainder add up to 1.
  float Transmittance(float mu, Row row) const { return Lookup2(transmittance_.data(), kMus, mu, row); }
  // The cosine-weighted mean over the hemisphere of min(Transmittance, cap), cap in [0, 1]; at cap 1 the lobe's 1 -
  // E_avg, exactly that of the interpolated table.
  float MeanTransmittance(Row row, float cap = 1) const { return Lookup2(mean_transmittance_.data(), kCaps, cap, row); }
  // Of all mu; that of normal incidence but for the table's errors.
  float LargestTransmittance(Row row) const { return Lookup1(largest_transmittance_.data(), row); }
  // What reaches the base by single scattering: refracted, and neither masked nor shadowed. Below Transmittance() where
  // the interface is rough.
  float SingleScatterTransmittance(float mu, Row row) const {
    return Lookup2(single_scatter_transmittance_.data(), kMus, mu, row);
  }
  // Under the flat interface, over a white GGX base (its alpha in `row`) lit from outside at mu: flux that leaves after
  // the second reflection on the base per flux that leaves after the first, and the mean of that ratio for later ones
  // (< 1).
  float SecondBounce(float mu, Row row) const { return Lookup2(second_bounce_.data(), kBaseMus, mu, row); }
  float LaterBounces(float mu, Row row) const { return Lookup2(later_bounces_.data(), kBaseMus, mu, row); }

  float eta() const { return eta_; }

 private:
  explicit CoatTable(float eta);
  void FillBounces(int row, float alpha);
  static float Lookup1(const float* table, Row row) {
    return table[row.index] + row.t * (table[row.index + 1] - table[row.index]);
  }
  static float Lookup2(const float* table, int columns, float mu, Row row) {
    const float x = std::min(mu, 1.0f) * static_cast<float>(columns - 1);
    const int i = std::min(static_cast<int>(x), columns - 2);
    const float t = x - static_cast<float>(i);
    const float* low = table + row.index * columns + i;
    const float* high = low + columns;
    const float a = low[0] + t * (low[1] - low[0]), b = high[0] + t * (high[1] - high[0]);
    return a + row.t * (b - a);
  }

  float eta_;
  std::array<float, kAlphas * kMus> transmittance_, single_scatter_transmittance_;
  std::array<float, kAlphas * kCaps> mean_transmittance_;
  std::array<float, kAlphas> largest_transmittance_;
  std::array<float, kAlphas * kBaseMus> second_bounce_, later_bounces_;
};

}  // namespace lodestar
