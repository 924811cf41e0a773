// Integrals of lobes over cells of the cylindrical square (directional_tree.h): over all 8 x 8 cells of its third level
// at once, and over the 4 x 4 cells two levels below any cell.
//
// How an LTC is integrated depends on how wide the cell is beside it. Up to its width: the density at the centre. Up to
// four times that: the density at four points. Wider: points that follow the lobe itself, each worth the same. All are
// cheap and true to the cells' shape, whatever the poles do; polygons with sides of great circles are neither.
#pragma once

#include <array>
#include <cstdint>

#include "core/guiding/product_lobes.h"

namespace lodestar::product {

inline constexpr int kSide = 8, kBlock = kSide * kSide;  // cell x + kSide y, x in cos theta, y in phi
inline constexpr int kBlockLevel = 3;
inline constexpr int kPatchSide = 4, kPatch = kPatchSide * kPatchSide;  // x + kPatchSide y
inline constexpr int kPatchLevels = 2;
inline constexpr int kFinest = 7;  // the deepest level whose cells are integrated over

struct alignas(32) Block : std::array<float, kBlock> {};
struct alignas(32) Patch : std::array<float, kPatch> {};

// The square root of the solid angle of a cell of `level`.
inline float CellSize(int level) {
  return 3.5449077f / static_cast<float>(1 << level);
}

// Adds weight * the integral of a cosine lobe about `normal` (over pi) over each cell. A cell's vector form factor F is
// exact; of a cell on the horizon a smooth function of n.F and |F| counts, as if it were round.
void AddCosine(Vec3 normal, float weight, Block& sum);
// Adds weight * the integral of the LTC, cut off below the horizon of `normal`.
void AddGlossy(const Ltc& ltc, Vec3 normal, float weight, Block& sum);

// Whether the lobe's density is far from even over the cells of `level`.
inline bool IsNarrow(const Ltc& ltc, int level) {
  return ltc.width() < 2 * CellSize(level);
}

// The lobes' mean densities, per steradian, over the cells two levels below cell (x, y) of `level`; level + 2 <=
// kFinest.
struct PatchDensities {
  Patch all;
  Patch narrow;             // what narrow lobes add to it
  bool has_narrow = false;  // else `narrow` is not set
};
PatchDensities Densities(const ProductLobes& lobes, int level, uint32_t x, uint32_t y);

}  // namespace lodestar::product
