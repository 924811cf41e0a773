// The 7 x 7 Gaussian of `dense` reconstruction over a square matrix, zero outside: separable, and leaving out what it
// cannot change (Nilsson 2023, section 4.3).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace lodestar::directional {

inline constexpr int kBlurRadius = 3;
inline constexpr int kBlurTile = 16;

// 2^depth rows and columns in a frame of zeros wide enough for the Gaussian. depth >= 4: whole tiles.
class FramedMatrix {
 public:
  explicit FramedMatrix(int depth);  // elements are not initialised
  int size() const { return size_; }
  // y from -kBlurRadius to size + kBlurRadius - 1, and so columns.
  float* Row(int y) { return values_.get() + (y + kBlurRadius) * stride_ + kFrame; }
  const float* Row(int y) const { return values_.get() + (y + kBlurRadius) * stride_ + kFrame; }

 private:
  static constexpr int kFrame = 8;  // columns on either side, a vector's width
  int size_, stride_;
  std::unique_ptr<float[]> values_;
};

// Which tiles hold one value that their surroundings within kBlurRadius hold, too: row by row of tiles.
using SameTiles = std::vector<uint8_t>;

// The kernel's half: weights at distance 0 to 3, both sides together 1.
std::array<float, kBlurRadius + 1> Gaussian(float sigma);

// `out`: size * size elements, row by row.
void Blur(const FramedMatrix& in, const SameTiles& same, const std::array<float, kBlurRadius + 1>& kernel, float* out);

}  // namespace lodestar::directional
