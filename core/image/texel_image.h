// An image texture in memory, made for lookups on every path vertex: 8-bit files stay 8-bit (a table linearises on the
// way out), others become floats; 8-bit texels lie in tiles of 4 x 4, one cache line each. Bilinear, base level only
// (docs/decisions/0004-textures.md says why).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/huge_pages.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"

namespace lodestar {

class TexelImage {
 public:
  enum class Wrap : uint8_t { kRepeat, kClamp, kBlack };
  enum class Encoding : uint8_t { kSrgb, kLinear, kGamma };  // of integer files

  // Throws Error naming the file (see ReadImage).
  static std::unique_ptr<TexelImage> Load(const std::string& path, Encoding encoding, float gamma);
  // From floats (1, 3 or 4 channels interleaved), for tests and constants.
  static std::unique_ptr<TexelImage> FromFloats(int width, int height, int channels, std::vector<float> values);

  // s to the right, t downwards, both over the whole image; `nearest`: no interpolation.
  Rgb LookupRgb(Vec2 st, Wrap wrap, bool nearest) const;
  // One channel: its value; three: their mean; four: the alpha, which is what a float texture from an RGBA file is for.
  float LookupFloat(Vec2 st, Wrap wrap, bool nearest) const;

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  size_t memory_bytes() const { return bytes_.size() * 4 + floats_.size() * 4; }

 private:
  // A texel's place in bytes_ (tiled) or floats_: the sum of what its column and its row contribute.
  template <bool kTiled>
  size_t Column(int x) const {
    return kTiled ? size_t(x >> 2) << 4 | (x & 3) : size_t(x) * channels_;
  }
  template <bool kTiled>
  size_t Row(int y) const {
    return kTiled ? size_t(y >> 2) * tiles_x_ << 4 | (y & 3) << 2 : size_t(y) * width_ * channels_;
  }
  template <bool kTiled, class Read>
  auto Filter(Vec2 st, Wrap wrap, bool nearest, Read read) const;

  int width_ = 0, height_ = 0, tiles_x_ = 0;
  int channels_ = 3;             // 1, 3 or 4 (4 only where some alpha is not one)
  LargeVector<uint32_t> bytes_;  // r | g << 8 | b << 16 | a << 24, tiled; empty for float images
  LargeVector<float> floats_;    // row by row
  std::array<float, 256> decode_{};
};

}  // namespace lodestar
