// Pictures of what a guide knows about directions, as grids of floats; whoever shows them gives them colours.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/guiding/directional_tree.h"

namespace lodestar {

// Row by row from the top.
struct FloatGrid {
  uint32_t width = 0, height = 0;
  std::vector<float> values;

  FloatGrid() = default;
  FloatGrid(uint32_t w, uint32_t h) : width(w), height(h), values(size_t{w} * h) {}
  float& At(uint32_t x, uint32_t y) { return values[size_t{y} * width + x]; }
  float At(uint32_t x, uint32_t y) const { return values[size_t{y} * width + x]; }
};

// How the sphere lies in a picture: +z at the top, phi = 0 (+x) at the left, growing to the right.
enum class SphereMap : uint8_t {
  kCylindrical,  // rows even in cos theta, a square: all pixels have the same solid angle
  kLatLong,      // rows even in theta, twice as wide as high
};

// The mean density over each pixel, exactly: 2^level pixels a side, cylindrical. Their mean is 1 / (4 pi).
FloatGrid DrawDirectionalTree(const DirectionalNode* nodes, int level);

// Of any density per steradian; each pixel the mean of 4 x 4 points, weighted by solid angle. Called from several
// threads at once.
FloatGrid DrawSphere(SphereMap map, uint32_t height, const std::function<float(Vec3)>& density);

// Over the sphere: 1 for a picture of a distribution, as far as its pixels resolve it.
double IntegrateSphere(SphereMap map, const FloatGrid& grid);

}  // namespace lodestar
