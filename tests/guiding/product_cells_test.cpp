#include "core/guiding/product_cells.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/guiding/product_cases.h"

namespace lodestar {
namespace {

using product::Block;
using product::kBlock;
using product::kSide;

// The mean of a density over points of a cell, times its solid angle.
double ByPoints(const std::function<float(Vec3)>& density, int level, uint32_t x, uint32_t y, int points) {
  double sum = 0;
  const float size = std::ldexp(1.0f, -level);
  for (int i = 0; i < points; ++i) {
    for (int j = 0; j < points; ++j) {
      const auto at = [&](uint32_t c, int k) {
        return (static_cast<float>(c) + (static_cast<float>(k) + 0.5f) / static_cast<float>(points)) * size;
      };
      sum += density(CylindricalToDirection({at(x, i), at(y, j)}));
    }
  }
  return sum / (points * points) * 4 * kPi * size * size;
}

// Half the sum of the absolute errors of all cells: the share of the lobe that is put in a wrong cell.
double Misplaced(const Block& block, const std::function<float(Vec3)>& density, int points) {
  double sum = 0;
  for (uint32_t c = 0; c < kBlock; ++c)
    sum += std::fabs(block[c] - ByPoints(density, product::kBlockLevel, c % kSide, c / kSide, points)) / 2;
  return sum;
}

std::vector<Frame> Frames() {
  std::vector<Frame> frames = {Frame{}, Frame::FromNormal({0, 0, -1}), Frame::FromNormal({1, 0, 0}),
                               Frame::FromNormal({0, -1, 0})};
  uint64_t rng = 4;
  while (frames.size() < 10) frames.push_back(Frame::FromNormal(SquareToSphere(synthetic::Unit2(rng))));
  return frames;
}

// Of the cosine lobe, cells on the horizon alone are approximate: 1.5 % of the lobe at most.
TEST(ProductCells, CosineIsInItsCells) {
  for (const Frame& frame : Frames()) {
    Block block;
    block.fill(0);
    product::AddCosine(frame.n, 1, block);
    const auto density = [&](Vec3 w) { return std::max(Dot(frame.n, w), 0.0f) * kInvPi; };
    EXPECT_LT(Misplaced(block, density, 24), 0.015);
    EXPECT_NEAR(std::accumulate(block.begin(), block.end(), 0.0), 1, 0.02);
  }
}

// Whatever the pole, the seam and the cells' shapes do. The worst lobe is nearly a quarter as wide as its cells and
// peaks in a corner, which four points see less of; the variance does not feel it (docs/decisions).
TEST(ProductCells, GlossyLobesAreInTheirCells) {
  double sum = 0;
  int count = 0;
  for (const Frame& frame : Frames()) {
    for (const float alpha : {0.02f, 0.06f, 0.2f, 0.6f}) {
      for (const float cos : {1.0f, 0.6f, 0.2f}) {
        SCOPED_TRACE(std::to_string(alpha) + " " + std::to_string(cos));
        const ProductLobe lobe{ProductLobe::Kind::kGgxReflection, alpha, 1};
        const ProductLobes lobes(frame, frame.ToWorld({SafeSqrt(1 - cos * cos), 0, cos}), {&lobe, 1});
        Block block;
        block.fill(0);
        product::AddGlossy(lobes.glossy(0), lobes.normal(), 1, block);
        const auto density = [&](Vec3 w) { return Dot(w, lobes.normal()) > 0 ? lobes.glossy(0).Density(w) : 0; };
        const double misplaced = Misplaced(block, density, alpha < 0.05f ? 160 : 48);
        EXPECT_LT(misplaced, 0.4);
        sum += misplaced;
        ++count;
      }
    }
  }
  EXPECT_LT(sum / count, 0.05);
}

// At every level down to the finest, the children of the cell under the lobe's peak.
TEST(ProductCells, ChildrenShareTheirParent) {
  for (const Frame& frame : Frames()) {
    for (const float alpha : {0.02f, 0.1f, 0.5f}) {
      const ProductLobe lobe{ProductLobe::Kind::kGgxReflection, alpha, 1};
      const ProductLobes lobes(frame, frame.ToWorld({0.6f, 0, 0.8f}), {&lobe, 1});
      const Vec2 peak = DirectionToCylindrical(frame.ToWorld({-0.6f, 0, 0.8f}));
      for (int level = product::kBlockLevel; level < product::kFinest; ++level) {
        SCOPED_TRACE(std::to_string(alpha) + " level " + std::to_string(level));
        const uint32_t x = directional::ToInteger(peak.x) >> (24 - level),
                       y = directional::ToInteger(peak.y) >> (24 - level);
        const auto children = product::Children(lobes, level, x, y);
        double total = 0, misplaced = 0;
        for (uint32_t c = 0; c < 4; ++c) {
          const double exact =
              ByPoints([&](Vec3 w) { return lobes.Density(w); }, level + 1, 2 * x + (c & 1), 2 * y + (c >> 1), 48);
          total += exact;
          misplaced += std::fabs(children[c] - exact) / 2;
        }
        EXPECT_LT(misplaced, 0.3 * total);
      }
    }
  }
}

}  // namespace
}  // namespace lodestar
