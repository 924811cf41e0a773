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

// Whatever the pole, the seam and the cells' shapes do. The worst lobes are much narrower than their cells: the points
// that follow them are few, and the variance hardly feels it (docs/decisions).
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
  EXPECT_LT(sum / count, 0.08);
}

// Two levels at a time, of the cells under the lobe's peak and of their neighbours.
TEST(ProductCells, DensitiesAreThoseOfTheLobes) {
  for (const Frame& frame : Frames()) {
    for (const float alpha : {0.02f, 0.1f, 0.5f}) {
      const std::array<ProductLobe, 2> all = {
          {{ProductLobe::Kind::kGgxReflection, alpha, 1}, {ProductLobe::Kind::kDiffuseTransmission, 1, 0.5f}}};
      const ProductLobes lobes(frame, frame.ToWorld({0.6f, 0, 0.8f}), all);
      const Vec2 peak = DirectionToCylindrical(frame.ToWorld({-0.6f, 0, 0.8f}));
      for (int level = product::kBlockLevel; level + product::kPatchLevels <= product::kFinest;
           level += product::kPatchLevels) {
        SCOPED_TRACE(std::to_string(alpha) + " level " + std::to_string(level));
        const int fine = level + product::kPatchLevels;
        const uint32_t x = directional::ToInteger(peak.x) >> (24 - level),
                       y = directional::ToInteger(peak.y) >> (24 - level);
        const auto found = product::Densities(lobes, level, x, y);
        EXPECT_EQ(found.has_narrow, product::IsNarrow(lobes.glossy(0), fine));
        const double area = Sqr(product::CellSize(fine));
        double total = 0, misplaced = 0, narrow = 0;
        for (uint32_t c = 0; c < product::kPatch; ++c) {
          const double exact =
              ByPoints([&](Vec3 w) { return lobes.Density(w); }, fine, 4 * x + c % 4, 4 * y + c / 4, 32);
          total += exact;
          misplaced += std::fabs(found.all[c] * area - exact) / 2;
          if (found.has_narrow) narrow += found.narrow[c] * area;
        }
        EXPECT_LT(misplaced, (alpha < 0.05f ? 0.3 : 0.1) * total);
        if (found.has_narrow) {
          EXPECT_GT(narrow, 0.5 * total);
        }
      }
    }
  }
}

// Beyond what the table has, down to M that are all but singular. The points that follow a lobe put all of it that is
// above the horizon somewhere; three points of 24 are allowed for.
TEST(ProductCells, ExtremeLobesStayFinite) {
  for (const Frame& frame : Frames()) {
    for (const LtcShape& shape :
         {LtcShape{1e-6f, 1, 1e3f, 0.9999f}, LtcShape{1, 1e-6f, 0, 0.9999f}, LtcShape{1e-6f, 1e-6f, 0, 0},
          LtcShape{1, 1, 0, 0.9999f}, LtcShape{1e3f, 1e3f, 0, 0}}) {
      SCOPED_TRACE(std::to_string(shape.x) + " " + std::to_string(shape.y) + " " + std::to_string(shape.skew));
      const Ltc ltc(shape, frame);
      Block block;
      block.fill(0);
      product::AddGlossy(ltc, frame.n, 1, block);
      for (const float cell : block) ASSERT_TRUE(std::isfinite(cell) && cell >= 0) << cell;
      if (ltc.width() < 0.1f) {
        EXPECT_NEAR(std::accumulate(block.begin(), block.end(), 0.0), ltc.ShareAbove(frame.n), 0.126);
      }
    }
  }
}

// Over all cells, of the table's narrowest and widest lobes from one end of its angles to the other.
TEST(ProductCells, DensitiesAreFiniteEverywhere) {
  for (const Frame& frame : Frames()) {
    for (const float alpha : {0.0f, 1e30f}) {
      for (const float cos : {1.0f, LtcTable::kMinCos + 1e-4f}) {
        SCOPED_TRACE(std::to_string(alpha) + " " + std::to_string(cos));
        const ProductLobe lobe{ProductLobe::Kind::kGgxReflection, alpha, 1};
        const ProductLobes lobes(frame, frame.ToWorld({SafeSqrt(1 - cos * cos), 0, cos}), {&lobe, 1});
        ASSERT_EQ(lobes.glossy_count(), 1);
        bool finite = true, within = true;
        for (int level = product::kBlockLevel; level + product::kPatchLevels <= product::kFinest;
             level += product::kPatchLevels) {
          for (uint32_t cell = 0; cell < 1u << (2 * level); ++cell) {
            const auto found = product::Densities(lobes, level, cell & ((1u << level) - 1), cell >> level);
            for (uint32_t c = 0; c < product::kPatch; ++c) {
              finite &= std::isfinite(found.all[c]) && found.all[c] >= 0;
              if (found.has_narrow) within &= found.narrow[c] >= 0 && found.narrow[c] <= found.all[c] * 1.00001f;
            }
          }
        }
        EXPECT_TRUE(finite);
        EXPECT_TRUE(within);
      }
    }
  }
}

}  // namespace
}  // namespace lodestar
