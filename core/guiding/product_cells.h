// Integrals of lobes over cells of the cylindrical square (directional_tree.h): over all 8 x 8 cells of its third level
// at once, and over the four children of any cell down to kFinest.
//
// A cell is bounded by two meridians and two parallels. The sides become great circles, of which meridians are; the
// third level's parallels are bent once in the middle, and those of finer cells are short. Edges are shared, so
// neighbouring cells never overlap and the integrals over a cell's children add up to that of their union.
//
// The integral of a cosine over a polygon partly below its horizon is had without clipping or its approximation by
// spheres (Hill and Heitz 2016): it is half the integral of r^2 dphi along the boundary, r the distance from the axis,
// and what of the boundary lies below the horizon is lifted to it along its meridian, where r is 1. So an edge is worth
// the same whichever cell it bounds; exact, and additive.
#pragma once

#include <array>
#include <cstdint>

#include "core/guiding/product_lobes.h"

namespace lodestar::product {

inline constexpr int kSide = 8, kBlock = kSide * kSide;  // cell x + kSide y, x in cos theta, y in phi
inline constexpr int kBlockLevel = 3;
inline constexpr int kFinest = 8;  // the deepest level whose cells are integrated over

struct alignas(32) Block : std::array<float, kBlock> {};

// Adds weight * the integral of a cosine lobe about `normal` (over pi) over each cell. A cell's vector
// form factor F is exact; of a cell on the horizon a smooth function of n.F and |F| counts, as if it were round.
void AddCosine(Vec3 normal, float weight, Block& sum);
// Adds weight * the integral of the LTC, cut off below the horizon of `normal`.
void AddGlossy(const Ltc& ltc, Vec3 normal, float weight, Block& sum);

// Adds weight * the integrals of the LTC over the children of cell (x, y) of `level` < kFinest, child x half + 2 y
// half.
void AddChildren(const Ltc& ltc, float weight, int level, uint32_t x, uint32_t y, std::array<float, 4>& sum);

}  // namespace lodestar::product
