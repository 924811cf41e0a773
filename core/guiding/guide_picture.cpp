#include "core/guiding/guide_picture.h"

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace lodestar {
namespace {

constexpr uint32_t kSubsamples = 4;

// Row borders in cos theta, from the top; t in [0, 1].
float CosAt(SphereMap map, float t) {
  return map == SphereMap::kCylindrical ? 1 - 2 * t : SinCos(kPi * (0.5f - t)).sin;
}

// (x, y): lower corner of the cell of `node` in the square, in pixels of the picture; `size`: its side.
void Fill(const DirectionalNode* nodes, uint32_t node, uint32_t x, uint32_t y, uint32_t size, double density,
          FloatGrid* grid) {
  const uint32_t half = size / 2;
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t cx = x + (c & 1 ? half : 0), cy = y + (c & 2 ? half : 0);
    const double inner = density * nodes[node].Share(c) * 0x1p-28;
    const uint32_t child = nodes[node].child[c];
    if (child != 0 && half > 1) {
      Fill(nodes, child, cx, cy, half, inner, grid);
      continue;
    }
    for (uint32_t py = cy; py < cy + half; ++py) {
      for (uint32_t px = cx; px < cx + half; ++px)
        grid->At(py, grid->height - 1 - px) = static_cast<float>(inner);  // phi to the right, cos theta upwards
    }
  }
}

}  // namespace

FloatGrid DrawDirectionalTree(const DirectionalNode* nodes, int level) {
  LODESTAR_CHECK(level >= 1 && level <= 12);
  const uint32_t side = 1u << level;
  FloatGrid grid(side, side);
  Fill(nodes, 0, 0, 0, side, kUniformSpherePdf, &grid);
  return grid;
}

FloatGrid DrawSphere(SphereMap map, uint32_t height, const std::function<float(Vec3)>& density) {
  FloatGrid grid(map == SphereMap::kCylindrical ? height : 2 * height, height);
  const float row = 1 / static_cast<float>(height * kSubsamples),
              column = 1 / static_cast<float>(grid.width * kSubsamples);
  ParallelFor(grid.height, [&](uint32_t y) {
    double weights = 0;
    for (uint32_t j = y * kSubsamples; j < (y + 1) * kSubsamples; ++j) {
      const float top = CosAt(map, static_cast<float>(j) * row), bottom = CosAt(map, static_cast<float>(j + 1) * row);
      const float weight = top - bottom, cos = 0.5f * (top + bottom);
      weights += weight * kSubsamples;
      for (uint32_t i = 0; i < grid.width * kSubsamples; ++i) {
        const Vec3 w = CylindricalToDirection({0.5f * (cos + 1), (static_cast<float>(i) + 0.5f) * column});
        grid.At(i / kSubsamples, y) += weight * density(w);
      }
    }
    for (uint32_t x = 0; x < grid.width; ++x) grid.At(x, y) /= static_cast<float>(weights);
  });
  return grid;
}

double IntegrateSphere(SphereMap map, const FloatGrid& grid) {
  double sum = 0;
  for (uint32_t y = 0; y < grid.height; ++y) {
    const float step = 1 / static_cast<float>(grid.height);
    const double height = CosAt(map, static_cast<float>(y) * step) - CosAt(map, static_cast<float>(y + 1) * step);
    double row = 0;
    for (uint32_t x = 0; x < grid.width; ++x) row += grid.At(x, y);
    sum += row * height * 2 * static_cast<double>(kPi) / grid.width;
  }
  return sum;
}

}  // namespace lodestar
