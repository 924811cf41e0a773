// The materials and directions over which the BSDF tests run.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/scene/bsdf.h"

namespace lodestar::test {

struct BsdfCase {
  std::string name;
  Bsdf bsdf;
};

inline const Rgb kGoldEta{0.143f, 0.375f, 1.442f}, kGoldK{3.983f, 2.386f, 1.603f};

inline std::vector<BsdfCase> BsdfCases() {
  return {
      {"diffuse", Bsdf::Diffuse({0.8f, 0.5f, 0.2f})},
      {"conductor 0.02", Bsdf::Conductor(kGoldEta, kGoldK, {0.02f, 0.02f})},
      {"conductor 0.3", Bsdf::Conductor(kGoldEta, kGoldK, {0.3f, 0.3f})},
      {"conductor 0.2 x 0.5", Bsdf::Conductor(kGoldEta, kGoldK, {0.2f, 0.5f})},
      {"conductor 1", Bsdf::Conductor(kGoldEta, kGoldK, {1, 1})},
      {"smooth conductor", Bsdf::Conductor(kGoldEta, kGoldK, {0, 0})},
      {"dielectric 1.5, 0.1", Bsdf::Dielectric(1.5f, {0.1f, 0.1f})},
      {"dielectric 1.33, 0.2 x 0.5", Bsdf::Dielectric(1.33f, {0.2f, 0.5f})},
      {"dielectric 1 / 1.5, 0.3", Bsdf::Dielectric(1 / 1.5f, {0.3f, 0.3f})},
      {"dielectric 1.8, 1", Bsdf::Dielectric(1.8f, {1, 1})},
      {"smooth dielectric", Bsdf::Dielectric(1.5f, {0, 0})},
      {"thin dielectric", Bsdf::ThinDielectric(1.5f)},
      {"coated diffuse 0.1", Bsdf::CoatedDiffuse({0.8f, 0.5f, 0.2f}, 1.5f, {0.1f, 0.1f})},
      {"coated diffuse 0.4 x 0.1", Bsdf::CoatedDiffuse(Rgb(0.3f), 1.7f, {0.4f, 0.1f})},
      {"coated diffuse, smooth", Bsdf::CoatedDiffuse({0.8f, 0.5f, 0.2f}, 1.5f, {0, 0})},
      {"coated diffuse 0.8", Bsdf::CoatedDiffuse({0.8f, 0.5f, 0.2f}, 1.5f, {0.8f, 0.8f})},
      {"coated conductor 0 over 0.2", Bsdf::CoatedConductor(1.5f, {0, 0}, kGoldEta, kGoldK, {0.2f, 0.2f})},
      {"coated conductor 0.2 over 0.1", Bsdf::CoatedConductor(1.5f, {0.2f, 0.2f}, kGoldEta, kGoldK, {0.1f, 0.1f})},
      {"coated conductor 0.3 over 0", Bsdf::CoatedConductor(1.5f, {0.3f, 0.3f}, kGoldEta, kGoldK, {0, 0})},
      {"coated conductor, smooth", Bsdf::CoatedConductor(1.5f, {0, 0}, kGoldEta, kGoldK, {0, 0})},
      {"diffuse transmission", Bsdf::DiffuseTransmission({0.5f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.4f})},
      {"none", Bsdf::None()},
  };
}

// On the upper side (theta in degrees from the normal) or the lower.
inline Vec3 Direction(double theta, double phi = 30) {
  const double t = theta * M_PI / 180, p = phi * M_PI / 180;
  return {static_cast<float>(std::sin(t) * std::cos(p)), static_cast<float>(std::sin(t) * std::sin(p)),
          static_cast<float>(std::cos(t))};
}

}  // namespace lodestar::test
