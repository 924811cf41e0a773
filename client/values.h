// Values as a user writes and reads them: durations, resolutions, counts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lodestar {

// "90", "90s", "1.5m", "2h", "1h30m", "250ms": seconds, > 0. Throws Error(kInvalidInput) naming the text and what is
// accepted.
double ParseDuration(std::string_view text);
// "0:07", "1:23:45"; "-:--" below zero (unknown).
std::string FormatDuration(double seconds);

// Pixels across and down.
struct PixelPair {
  uint32_t x = 0, y = 0;
};
using Resolution = PixelPair;
using Pixel = PixelPair;  // (0,0) is the upper left one
// "640x360". Throws Error(kInvalidInput).
Resolution ParseResolution(std::string_view text);
// "12,34". Throws Error(kInvalidInput).
Pixel ParsePixel(std::string_view text);

// 3.21 M, 870 k, 12
std::string FormatCount(double value);
// 1.2 GB, powers of 1000.
std::string FormatBytes(double bytes);
// Shortest text of at most four significant digits.
std::string FormatNumber(double value);

// A word as a shell would need it quoted to be one argument again.
std::string ShellQuote(std::string_view word);

}  // namespace lodestar
