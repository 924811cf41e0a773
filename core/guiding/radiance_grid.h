// Incident radiance as a table over a regular grid: voxels of the scene's box times equal-area cells of the sphere
// (Kim 2022, chapter 3). An immutable state: every worker of a step guides by the same bits and records into
// GridStatistics; Advance() makes the next one.
//
// The box is enlarged a little, each side at least an eighth of the longest, so that flat scenes have a volume.
// Directions are cells of the cylindrical equal-area square (core/math/warp.h): `directions` rows of cos theta, twice
// as many columns of phi.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/guiding/grid_options.h"
#include "core/guiding/guide_box.h"
#include "core/math/warp.h"

namespace lodestar {

// The pieces of a state; RadianceGrid's constructor checks that they fit together.
struct GridParts {
  GridOptions options;
  GuideBox box;
  uint32_t iteration = 0;
  float radiance_scale = 1;  // a power of two that brings recorded values near 1
  // By voxel, then row, then column: mean luminance arriving from the entry's directions, and how much is known of it:
  // 0: nothing, towards 1 as 1 - (1 - a)^records.
  std::vector<float> radiance, weight;
};

class RadianceGrid {
 public:
  // Knows nothing. Throws Error(kInvalidInput) for bounds that are empty or not finite, or bad options.
  static std::shared_ptr<const RadianceGrid> Initial(const Bounds3& bounds, const GridOptions& options);
  explicit RadianceGrid(GridParts parts);

  // The voxel of a point; of points outside, the nearest.
  uint32_t CellAt(Vec3 p) const {
    uint32_t cell = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const float along = std::clamp((p[axis] - parts_.box.corner[axis]) * per_cell_[axis], 0.0f, last_cell_);
      cell = cell * static_cast<uint32_t>(parts_.options.cells) + static_cast<uint32_t>(along);
    }
    return cell;
  }
  // The cell of the sphere that holds a unit vector.
  uint32_t DirectionAt(Vec3 w) const {
    const Vec2 square = DirectionToCylindrical(w);
    const auto rows = static_cast<uint32_t>(parts_.options.directions);
    return static_cast<uint32_t>(square.x * static_cast<float>(rows)) * 2 * rows +
           static_cast<uint32_t>(square.y * static_cast<float>(2 * rows));
  }
  Vec3 DirectionCenter(uint32_t direction) const;

  // Estimates, with what is known of the directions around (GridOptions::prior) where an entry itself knows little.
  float Radiance(uint32_t cell, uint32_t direction) const { return estimate_[Entry(cell, direction)]; }
  std::span<const float> Radiances(uint32_t cell) const {
    return std::span(estimate_).subspan(Entry(cell, 0), direction_count());
  }
  // The integral of the radiance over the sphere.
  float Fluence(uint32_t cell) const { return fluence_[cell]; }

  const GridOptions& options() const { return parts_.options; }
  const GridParts& parts() const { return parts_; }
  uint32_t iteration() const { return parts_.iteration; }
  float radiance_scale() const { return parts_.radiance_scale; }
  uint32_t cell_count() const { return parts_.options.cell_count(); }
  uint32_t direction_count() const { return parts_.options.direction_count(); }
  size_t Entry(uint32_t cell, uint32_t direction) const { return size_t{cell} * direction_count() + direction; }
  // A hash of the content, for telling states apart; not a content address.
  uint64_t fingerprint() const { return fingerprint_; }

  // Canonical: equal grids have equal bytes. Voxels of which nothing is known take none.
  Bytes Serialize() const;
  // Throws Error(kCorrupt) for anything but what Serialize() wrote.
  static std::shared_ptr<const RadianceGrid> Parse(std::string_view bytes);

 private:
  void Estimate(uint32_t cell);

  GridParts parts_;
  Vec3 per_cell_;  // 1 / a voxel's sides
  float last_cell_;
  std::vector<float> estimate_, fluence_;
  uint64_t fingerprint_;
};

}  // namespace lodestar
