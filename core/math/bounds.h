// Axis-aligned boxes.
#pragma once

#include "core/math/vec.h"

namespace lodestar {

struct Bounds3 {
  Vec3 min{kInfinity, kInfinity, kInfinity};
  Vec3 max{-kInfinity, -kInfinity, -kInfinity};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  Vec3 Diagonal() const { return max - min; }
  Vec3 Center() const { return min * 0.5f + max * 0.5f; }
  void Extend(Vec3 p) {
    min = Min(min, p);
    max = Max(max, p);
  }
  void Extend(const Bounds3& b) {
    min = Min(min, b.min);
    max = Max(max, b.max);
  }
  friend bool operator==(const Bounds3&, const Bounds3&) = default;
};

}  // namespace lodestar
