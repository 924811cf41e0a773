// What a dielectric coat lets through, tabulated: the quantities from which the coated materials are composed
// analytically.
//
// A coat is a flat or GGX-rough dielectric interface over an empty layer. pbrt-v4's layered materials let the layer
// absorb exp(-thickness / |cos|) on every crossing even without a medium (thickness 0.01 unless the scene says
// otherwise) and cut the walk after `maxdepth` interactions with either boundary; both are reproduced here, so that the
// means agree.
#pragma once

#include <array>

#include "core/math/vec.h"

namespace lodestar {

// As pbrt-v4's parameters "thickness" and "maxdepth" of its coated materials, with its defaults.
struct CoatOptions {
  float thickness = 0.01f;  // 0: a lossless coat
  int max_depth = 10;       // interactions inside the coat; 0: no limit (the whole series)
  // Interactions alternate between base and interface, beginning with the base.
  int BaseBounces() const { return max_depth <= 0 ? 0 : (max_depth + 1) / 2; }
};

// The part of light that crosses the layer once at the cosine mu.
float LayerTransmittance(float thickness, float mu);

// Tables over (mu, alpha) of one coat, alpha isotropic: alpha = (row / (kAlphas - 1))^2, row 0 the flat interface;
// linear between nodes.
class CoatTable {
 public:
  static constexpr int kMus = 128, kAlphas = 32, kBaseMus = 64;
  struct Row {
    int index;  // <= kAlphas - 2
    float t;
  };
  static Row RowOf(float alpha);

  // The table of a coat: computed at first use (about 20 ms) and kept for the life of the process; any thread. Later
  // calls take no lock.
  static const CoatTable& For(float eta, float thickness);

  // Flux that reaches the base per unit flux arriving from outside at mu, by single scattering on the rough interface.
  // By reciprocity also what leaves towards mu from diffuse light inside: radiance outside = Transmittance(mu) / eta^2
  // * radiance inside.
  float Transmittance(float mu, Row row) const { return Lookup2(transmittance_.data(), kMus, mu, row); }
  // Its cosine-weighted mean over the hemisphere.
  float MeanTransmittance(Row row) const { return Lookup1(mean_transmittance_.data(), row); }
  // Diffuse flux leaving the base that comes back to it from the interface.
  float InternalReflectance(Row row) const { return Lookup1(internal_reflectance_.data(), row); }
  // Under the flat interface, over a white GGX base (its alpha in `row`) lit from outside at mu: flux that leaves after
  // the second reflection on the base per flux that leaves after the first, and the mean of that ratio for later ones.
  float SecondBounce(float mu, Row row) const { return Lookup2(second_bounce_.data(), kBaseMus, mu, row); }
  float LaterBounces(float mu, Row row) const { return Lookup2(later_bounces_.data(), kBaseMus, mu, row); }

  float eta() const { return eta_; }
  float thickness() const { return thickness_; }

 private:
  CoatTable(float eta, float thickness);
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

  float eta_, thickness_;
  std::array<float, kAlphas * kMus> transmittance_;
  std::array<float, kAlphas> mean_transmittance_, internal_reflectance_;
  std::array<float, kAlphas * kBaseMus> second_bounce_, later_bounces_;
};

}  // namespace lodestar
