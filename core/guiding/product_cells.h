// Integrals of lobes over cells of the cylindrical square (directional_tree.h): over all 8 x 8 cells of its third level
// at once, and over the four children of any cell.
//
// How an LTC is integrated depends on how wide the cell is beside it. Up to its width: the density at the centre, for
// children. Up to four times that: the density at four points. Wider: the closed form over polygons, whose sides are
// great circles. Meridians are; the third level's parallels are bent once in the middle, and those of finer cells are
// short. Neighbours share their edges, so they never overlap and the integrals over children add up to their parent's.
// The points are the cheapest and true to the cell's shape; the closed form cannot miss a lobe.
//
// The integral of a cosine over a polygon partly below its horizon is had without clipping, or its approximation by
// spheres (Hill and Heitz 2016): it is half the integral of r^2 dphi along the boundary, r the distance from the axis,
// and what of the boundary lies below the horizon is lifted to it along its meridian, where r is 1. So an edge is worth
// the same whichever cell it bounds.
#pragma once

#include <array>
#include <cstdint>

#include "core/guiding/product_lobes.h"

namespace lodestar::product {

inline constexpr int kSide = 8, kBlock = kSide * kSide;  // cell x + kSide y, x in cos theta, y in phi
inline constexpr int kBlockLevel = 3;
inline constexpr int kFinest = 8;  // the deepest level whose cells are integrated over

struct alignas(32) Block : std::array<float, kBlock> {};

// The square root of the solid angle of a cell of `level`.
inline float CellSize(int level) {
  return 3.5449077f / static_cast<float>(1 << level);
}

// Adds weight * the integral of a cosine lobe about `normal` (over pi) over each cell. A cell's vector form factor F is
// exact; of a cell on the horizon a smooth function of n.F and |F| counts, as if it were round.
void AddCosine(Vec3 normal, float weight, Block& sum);
// Adds weight * the integral of the LTC, cut off below the horizon of `normal`.
void AddGlossy(const Ltc& ltc, Vec3 normal, float weight, Block& sum);

// The integrals of all the lobes over the children of cell (x, y) of `level` < kFinest, child x half + 2 y half.
std::array<float, 4> Children(const ProductLobes& lobes, int level, uint32_t x, uint32_t y);

}  // namespace lodestar::product
