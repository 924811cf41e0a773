// From linear RGB of other primaries to ours, Rec. 709.
#pragma once

#include <array>
#include <optional>

#include "core/math/rgb.h"

namespace lodestar {

// CIE 1931 xy of red, green, blue and white, in turn (OpenEXR's "chromaticities").
using Chromaticities = std::array<float, 8>;
inline constexpr Chromaticities kRec709{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};

// What becomes of the other space's white, where it is not D65: light keeps its colour, as in pbrt-v4; to a surface it
// is white, so it becomes ours (Bradford's adaptation: Lam 1985, as in ICC.1:2022, annex E).
enum class WhitePoint { kKept, kAdapted };

class PrimariesMatrix {
 public:
  // The colour in Rec. 709; what is outside of its gamut has its negative components set to zero.
  Rgb operator()(Rgb c) const;

 private:
  friend std::optional<PrimariesMatrix> ToRec709(const Chromaticities& from, WhitePoint white);
  std::array<double, 9> m_{};  // rows
};

// None where the chromaticities are of no colour space: primaries in a line, or a white of no luminance.
std::optional<PrimariesMatrix> ToRec709(const Chromaticities& from, WhitePoint white);

}  // namespace lodestar
