// A race of methods for one image: which of them lowers the error most for its cost, from pilot iterations of each.
//
// Efficiency = 1 / (relative variance of a pixel sample * cost of a pass), with an interval from the spread between
// blocks of the image. All films of a race are measured against one estimate of the pixels, and nothing is trimmed: the
// variance of few passes sits in few bright samples, and to leave those out would be to take the noisiest method for
// the best.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/film/pixel_estimate.h"

namespace lodestar {

struct PilotResult {
  uint32_t candidate = 0;
  uint64_t passes = 0;
  double work = 0;  // of a pass, any unit common to the candidates
  std::vector<double>
      variances;  // relative variance of a sample, mean of each block; all films of a race have the same blocks

  void Write(ByteWriter& out) const;
  static PilotResult Read(ByteReader& in);
};

// From the film of an iteration, of at least two passes; `work` is the whole iteration's, `pixels` what its pixels are
// expected to have.
PilotResult MeasurePilot(uint32_t candidate, const Film& film, double work, const PixelEstimate& pixels);

// How much more efficient a is than b, with the bounds of a 95 % interval on the ratio from jackknifing the blocks.
struct EfficiencyRatio {
  double value = 1, low = 0, high = 0;
};
EfficiencyRatio CompareEfficiency(const PilotResult& a, const PilotResult& b);

}  // namespace lodestar
