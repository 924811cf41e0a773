// Pixel sums. A tile carries what one unit rendered in one round, in floats; the film adds tiles in round order, in
// doubles, so that a million passes do not drift. Units of one round never share a pixel, so adding a round's tiles is
// a disjoint union.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/math/rgb.h"

namespace lodestar {

struct TileRect {
  uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // half open
  uint32_t width() const { return x1 - x0; }
  uint32_t height() const { return y1 - y0; }
  uint32_t pixels() const { return width() * height(); }
};

// The image cut into tiles, row by row; a tile's index is its unit's index.
class TileGrid {
 public:
  static constexpr uint32_t kTileSize = 16;
  TileGrid(uint32_t width, uint32_t height)
      : width_(width),
        height_(height),
        columns_((width + kTileSize - 1) / kTileSize),
        rows_((height + kTileSize - 1) / kTileSize) {}
  uint32_t tile_count() const { return columns_ * rows_; }
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  TileRect Rect(uint32_t tile) const;
  // The tile that holds a pixel of the image.
  uint32_t TileAt(uint32_t x, uint32_t y) const { return y / kTileSize * columns_ + x / kTileSize; }

 private:
  uint32_t width_, height_, columns_, rows_;
};

// Sums over a unit's passes: RGB, and the square of the luminance for the variance of the mean.
struct PixelSum {
  float r = 0, g = 0, b = 0, luminance_squared = 0;
  // A sample's radiance, finite (the tracer's gate saw to that). Sums that would overflow stay at the largest float;
  // false where one did.
  bool Add(Rgb sample);
  friend bool operator==(const PixelSum&, const PixelSum&) = default;
};

struct FilmTile {
  uint32_t tile = 0;
  std::vector<PixelSum> pixels;  // row-major within the tile's rectangle
};

// A developed picture: linear RGB and the variance of the luminance of each pixel's mean (0 where a single sample tells
// nothing).
struct Image {
  uint32_t width = 0, height = 0;
  std::vector<Rgb> pixels;
  std::vector<float> variance;
  size_t size() const { return pixels.size(); }
};

class Film {
 public:
  Film() = default;
  explicit Film(const TileGrid& grid);
  // That develops into `image`, of at least two passes: a mean of films as one.
  Film(const Image& image, uint64_t passes);
  // Adds a tile of this grid's size; AddPasses once a round, when all its tiles are added.
  void Add(const TileGrid& grid, const FilmTile& tile);
  void AddPasses(uint32_t passes) { passes_ += passes; }
  uint64_t passes() const { return passes_; }
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  // Of memory.
  static uint64_t Bytes(const TileGrid& grid) { return uint64_t{grid.width()} * grid.height() * sizeof(Sum); }

  Image Develop() const;
  // Mean over pixels of the variance of the pixel mean, each pixel's clamped to `clamp` times the median of those above
  // zero so that a firefly does not own a weight; infinity below two passes, 0 for a picture without any noise (a black
  // one, say).
  double MeanVariance(double clamp = 1000) const;

  void Write(ByteWriter& out) const;
  // Fails the reader (Error kCorrupt) where size and pixels do not fit or a sum is not finite.
  static Film Read(ByteReader& in);

 private:
  struct Sum {
    double r = 0, g = 0, b = 0, luminance_squared = 0;
  };
  double MeanLuminance(const Sum& sum) const;
  double Variance(const Sum& sum) const;  // of the mean luminance

  uint32_t width_ = 0, height_ = 0;
  uint64_t passes_ = 0;
  std::vector<Sum> sums_;
};

}  // namespace lodestar
