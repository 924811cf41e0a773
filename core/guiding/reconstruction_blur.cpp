#include "core/guiding/reconstruction_blur.h"

#include <algorithm>

#include "core/math/elementary.h"

namespace lodestar::directional {
namespace {

using Kernel = std::array<float, kBlurRadius + 1>;

// to[i] = the kernel over from[i - 3 step] ... from[i + 3 step].
inline void Convolve(const float* from, ptrdiff_t step, const Kernel& k, int count, float* __restrict to) {
  for (int i = 0; i < count; ++i) {
    const float* const f = from + i;
    to[i] = (k[0] * f[0] + k[1] * (f[-step] + f[step])) +
            (k[2] * (f[-2 * step] + f[2 * step]) + k[3] * (f[-3 * step] + f[3 * step]));
  }
}

}  // namespace

FramedMatrix::FramedMatrix(int depth)
    : size_(1 << depth),
      stride_(size_ + 2 * kFrame),
      values_(std::make_unique_for_overwrite<float[]>(static_cast<size_t>(size_ + 2 * kBlurRadius) * stride_)) {
  for (int y = -kBlurRadius; y < size_ + kBlurRadius; ++y) {
    if (y < 0 || y >= size_) {
      std::fill_n(Row(y) - kFrame, stride_, 0.0f);
    } else {
      std::fill_n(Row(y) - kFrame, kFrame, 0.0f);
      std::fill_n(Row(y) + size_, kFrame, 0.0f);
    }
  }
}

Kernel Gaussian(float sigma) {
  Kernel kernel;
  float sum = 0;
  for (int i = 0; i <= kBlurRadius; ++i) {
    kernel[i] = Exp(-0.5f * static_cast<float>(i * i) / (sigma * sigma));
    sum += i == 0 ? kernel[i] : 2 * kernel[i];
  }
  for (float& k : kernel) k /= sum;
  return kernel;
}

void Blur(const FramedMatrix& in, const SameTiles& same, const Kernel& kernel, float* out) {
  const int size = in.size(), tiles = size / kBlurTile;
  constexpr int kRows = kBlurTile + 2 * kBlurRadius;
  std::vector<float> band(static_cast<size_t>(kRows) * size);  // rows around a row of tiles, blurred along x
  for (int tile_y = 0; tile_y < tiles; ++tile_y) {
    const uint8_t* const row_same = same.data() + static_cast<size_t>(tile_y) * tiles;
    const int y0 = tile_y * kBlurTile;
    for (int begin = 0, end; begin < tiles; begin = end) {
      // A run of tiles of one kind.
      end = begin + 1;
      while (end < tiles && row_same[end] == row_same[begin]) ++end;
      const int x0 = begin * kBlurTile, count = (end - begin) * kBlurTile;
      float* to = out + static_cast<size_t>(y0) * size + x0;
      if (row_same[begin]) {
        for (int y = 0; y < kBlurTile; ++y, to += size) std::copy_n(in.Row(y0 + y) + x0, count, to);
        continue;
      }
      for (int y = 0; y < kRows; ++y)
        Convolve(in.Row(y0 + y - kBlurRadius) + x0, 1, kernel, count, band.data() + static_cast<size_t>(y) * size);
      for (int y = 0; y < kBlurTile; ++y, to += size)
        Convolve(band.data() + static_cast<size_t>(y + kBlurRadius) * size, size, kernel, count, to);
    }
  }
}

}  // namespace lodestar::directional
