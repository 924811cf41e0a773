// Pictures of grids of values for people: a perceptual colour map on a logarithmic scale, with a title and a legend.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/guiding/guide_picture.h"

namespace lodestar {

using Colour = std::array<uint8_t, 3>;  // sRGB

class Canvas {
 public:
  Canvas(uint32_t width, uint32_t height, Colour background);
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  void Set(uint32_t x, uint32_t y, Colour colour);  // outside: nothing
  void Fill(uint32_t x, uint32_t y, uint32_t width, uint32_t height, Colour colour);
  // In capitals of 5 x 7 points with one between them, each scale x scale pixels; (x, y): upper left corner.
  void Text(uint32_t x, uint32_t y, std::string_view text, uint32_t scale, Colour colour);
  static uint32_t TextWidth(std::string_view text, uint32_t scale) {
    return static_cast<uint32_t>(text.size()) * 6 * scale;
  }
  void WritePng(const std::filesystem::path& path) const;

 private:
  uint32_t width_, height_;
  std::vector<uint8_t> bytes_;
};

// Values from low to high, logarithmic; below low as low, above high as high.
struct LogScale {
  float low = 0.1f, high = 1;
  // From the smallest positive value, or 1e-5 of the largest if that is more, to the largest.
  static LogScale Of(const FloatGrid& grid);
  float Position(float value) const;  // in [0, 1]
};

struct PictureStyle {
  std::string title, caption;                  // above the picture, and beside the legend: what the colours mean
  std::optional<LogScale> scale;               // LogScale::Of(grid) where not given
  std::vector<uint8_t> borders;                // 1 where a pixel is darkened; empty: none
  std::optional<std::array<float, 2>> marker;  // a cross, in pixels of the grid
  std::vector<float> shade;                    // grey levels in [0, 1] that are blended in; empty: none
};

// Pixels of the grid are enlarged by a whole number until its longer side is 384 or more. Zero is black.
Canvas DrawPicture(const FloatGrid& grid, const PictureStyle& style);

}  // namespace lodestar
