// Radiance grids to test with: a room with a small bright ball, learned in as a renderer would.
#pragma once

#include <vector>

#include "core/guiding/grid_advance.h"
#include "tests/support/statistical.h"

namespace lodestar::grid_testing {

using test::Random;

inline constexpr Bounds3 kUnit{{0, 0, 0}, {1, 1, 1}};

inline Vec3 UniformDirection(Random& random) {
  return SquareToSphere(random.Next2D());
}
inline Vec3 PointIn(const Bounds3& box, Random& random) {
  const Vec2 u = random.Next2D();
  return box.min + Vec3{u.x, u.y, random.Next1D()} * box.Diagonal();
}

// From x along w, in a room that glows dimly above and has a ball of light.
inline float RadianceIn(const Bounds3& box, Vec3 x, Vec3 w) {
  const Vec3 to_ball = box.min + box.Diagonal() * Vec3{0.3f, 0.7f, 0.6f} - x;
  const float cos = Dot(w, to_ball) / std::max(Length(to_ball), 1e-30f);
  return (cos > 0.97f ? 50.0f : 0.0f) + std::max(w.z, 0.0f) + 0.05f;
}

inline GridStatistics Recorded(std::shared_ptr<const RadianceGrid> grid, const Bounds3& box, uint64_t seed, int records,
                               float emission = 1) {
  GridStatistics statistics(grid);
  Random random(seed);
  for (int i = 0; i < records; ++i) {
    const Vec3 x = PointIn(box, random), w = UniformDirection(random);
    const float noise = 2 * random.Next1D();
    statistics.Record(grid->CellAt(x), grid->DirectionAt(w), emission * noise * RadianceIn(box, x, w));
  }
  return statistics;
}

inline std::shared_ptr<const RadianceGrid> Train(const GridOptions& options, const Bounds3& box = kUnit,
                                                 int records = 200000, float emission = 1) {
  auto grid = RadianceGrid::Initial(box, options);
  for (uint64_t step = 0; step < 3; ++step) grid = Advance(*grid, Recorded(grid, box, 100 + step, records, emission));
  return grid;
}

}  // namespace lodestar::grid_testing
