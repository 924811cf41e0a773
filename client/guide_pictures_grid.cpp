#include "client/guide_pictures.h"

namespace lodestar {

void DrawGrid(const RadianceGrid& grid, const GuideView& view, PictureFolder* out) {
  if (!view.point) return;
  const uint32_t cell = grid.CellAt(view.point->p);
  if (!(grid.Fluence(cell) > 0)) return;
  const float scale = 1 / grid.Fluence(cell);
  out->DrawDensity("table", "radiance of the voxel, normalised",
                   [&](Vec3 w) { return grid.Radiance(cell, grid.DirectionAt(w)) * scale; });
}

}  // namespace lodestar
