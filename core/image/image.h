// Image files, in and out. Pixels are row by row from the upper left corner, channels interleaved.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/math/rgb.h"

namespace lodestar {

struct FloatImage {
  int width = 0, height = 0;
  std::vector<Rgb> pixels;
  Rgb& At(int x, int y) { return pixels[size_t(y) * width + x]; }
  Rgb At(int x, int y) const { return pixels[size_t(y) * width + x]; }
};

// Light in linear Rec. 709. 8- and 16-bit files are taken for sRGB and linearised, float files for linear, of the
// primaries that they name (EXR's chromaticities); a single channel is copied to all three, alpha is left out. Throws
// Error(kNotFound) for a missing and Error(kCorrupt) for an unreadable file, naming it.
FloatImage ReadImage(const std::string& path);

// One named channel of an EXR: width * height values at `stride` floats from each other.
struct ImageChannel {
  std::string name;  // "R", "G", "B", or "albedo.R", "variance.R", ...
  const float* values = nullptr;
  int stride = 1;
};
struct ExrOptions {
  bool half = false;  // 16-bit floats
  std::map<std::string, std::string> metadata;
};
// Writes beside the name first and renames: a reader never sees half a file. Throws Error(kIo).
void WriteExr(const std::string& path, int width, int height, const std::vector<ImageChannel>& channels,
              const ExrOptions& options = {});
void WriteExr(const std::string& path, const FloatImage& image, const ExrOptions& options = {});

// PNG of sRGB bytes (RGB, 3 a pixel), written as WriteExr writes. Throws Error(kIo).
void WritePng(const std::string& path, int width, int height, const std::vector<uint8_t>& bytes);
// Such bytes of a linear image times 2^exposure; values above 1 clip.
std::vector<uint8_t> ToSrgb8(const FloatImage& image, float exposure = 0);
void WritePng(const std::string& path, const FloatImage& image, float exposure = 0);

}  // namespace lodestar
