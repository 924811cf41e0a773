// A race of methods for one image: which of them lowers the error most for its cost, from pilot iterations of each.
//
// Efficiency = 1 / (relative variance of a pixel sample * cost of a pass), with an interval from the spread between
// blocks of the image. All films of a race are measured against one yardstick. Less is trimmed than in reports: the
// variance of few passes sits in few bright samples, and to leave those out would be to take the noisiest method for
// the best; to keep single outliers would be to decide by one sample.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/film/pixel_estimate.h"

namespace lodestar {

// What the films of a race are measured against: the job's image so far, all films in it.
class Yardstick {
 public:
  explicit Yardstick(const Image& image);
  const PixelEstimate& pixels() const { return pixels_; }
  // Mean luminance of the image in each block; a block is a 64th of the image (an eighth of each side).
  const std::vector<double>& blocks() const { return blocks_; }
  // What is added to squares of luminance: RelativeEpsilon of the image.
  double epsilon() const { return epsilon_; }

 private:
  PixelEstimate pixels_;
  std::vector<double> blocks_;
  double epsilon_;
};

struct PilotResult {
  uint32_t candidate = 0;
  uint64_t passes = 0;
  double work = 0;  // of a pass, any unit common to the candidates
  // relative variance of a sample, mean of each block; all films of a race have the same blocks
  std::vector<double> variances;

  void Write(ByteWriter& out) const;
  static PilotResult Read(ByteReader& in);
};

// From the film of an iteration, of at least two passes; `work` is the whole iteration's.
//
// A film cannot tell the variance of light that it has not met. Where a block of N samples lacks a part d of the light
// that the yardstick has there, by more than five standard errors, that part comes in samples of which fewer than one
// in N is met: its variance is at least d^2 N, and counts as that.
PilotResult MeasurePilot(uint32_t candidate, const Film& film, double work, const Yardstick& yardstick);

// How much more efficient a is than b, with the bounds of a 95 % interval on the ratio from jackknifing the blocks.
struct EfficiencyRatio {
  double value = 1, low = 0, high = 0;
};
EfficiencyRatio CompareEfficiency(const PilotResult& a, const PilotResult& b);

// Variance of a pixel sample over the square of the film's mean, outliers clamped (Film::MeanVariance): about one over
// the share of samples that meet the light. Infinity for a black film and below two passes.
double RelativeVariance(const Film& film);

}  // namespace lodestar
