// Error of an image against a reference, or estimated from its own variance (docs/measuring.md). Linear radiance, mean
// over pixels and channels.
#pragma once

#include "core/film/film.h"

namespace lodestar {

struct ErrorMetrics {
  double rmse = 0, mse = 0, mae = 0;
  double relmse = 0;          // mean((x - r)^2 / (r^2 + eps)), eps = 0.01
  double relmse_trimmed = 0;  // the worst 0.1 % of pixels left out
};
inline constexpr double kRelMseEpsilon = 0.01;
inline constexpr double kTrimmedFraction = 0.001;
// What stands for eps where images of one scene are weighed against each other: that of reports for a picture that is
// exposed for display (of mean luminance 1), so that the scene's unit of light does not matter. Above zero.
double RelativeEpsilon(double mean_luminance);

// Throws Error(kInvalidInput) where the sizes differ or a pixel of either is not finite (naming it).
ErrorMetrics Compare(const Image& image, const Image& reference);
// Expected relMSE of the image from the variances of its pixels: mean(variance / (luminance^2 + eps)), and
// TrimmedVariance of that; infinity for an image without variances. The luminance is the mean over 3x3 pixels: a
// pixel's own is correlated with its variance (a firefly raises both), which hides up to all of the error above 1.
struct EstimatedError {
  double relmse = 0, relmse_trimmed = 0;
};
EstimatedError EstimateError(const Image& image);
// Mean of a picture's relative variances, one a pixel. The worst (a share of the pixels) are left out as outliers,
// unless they hold more than a quarter of its light: then they are not outliers but what has been met so far, and count
// relative to `square`, that of the mean of all pixels (plus eps), since what is expected of them is mostly themselves.
double TrimmedVariance(const Image& image, const std::vector<double>& relative, double square,
                       double left_out = kTrimmedFraction);
// The value that only the worst `left_out` of them (rounded down) are above.
double LargestKept(std::vector<double> values, double left_out);
// Relative luminance error per pixel, (lum x - lum r) / (lum r + eps); for the false-colour map of Lukac 2011.
std::vector<float> RelativeLuminanceError(const Image& image, const Image& reference);
// A perceptual diverging colour map for that error, +-limit at the ends (blue below, orange above, nearly white at 0,
// black for NaN): sRGB bytes, 3 a pixel. `limit` > 0.
std::vector<uint8_t> FalseColour(const std::vector<float>& values, float limit = 1);

}  // namespace lodestar
