// `render --aov`: features of the first hit as further channels of the EXR, and what a guide does there as pictures.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/tracing/feature_pass.h"

namespace lodestar {

struct AovChoice {
  bool albedo = false, normal = false, depth = false, bsdf_fraction = false, nee = false;
  bool any() const { return albedo || normal || depth || shares(); }
  bool shares() const { return bsdf_fraction || nee; }

  // "albedo,normal". Throws Error(kInvalidInput) naming the word and what there is.
  static AovChoice Parse(const std::string& text);
};

// albedo.R, .G, .B; N.X, .Y, .Z; Z; guide.bsdf_fraction; guide.nee. They point into `features`.
std::vector<ImageChannel> AovChannels(const AovChoice& choice, const Features& features);

// The share of BSDF sampling in false colour (Diolatzis et al. 2020, figure 3): blue where the guide draws directions,
// orange where the BSDF does, nearly white at one half, black where no smooth surface was found.
void WriteFractionPng(const std::filesystem::path& path, const Features& features);

}  // namespace lodestar
