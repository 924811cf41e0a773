// The radiance grid's bytes, version 1: header, then the voxels of which something is known, ascending, and all their
// entries.
#include <cmath>

#include "core/guiding/radiance_grid.h"
#include "core/guiding/radiance_scale.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("GRID");
constexpr uint32_t kVersion = 1;

// Zero or a positive number, without the sign that would make two forms of zero.
bool Canonical(float value, float most) {
  return value >= 0 && value <= most && !std::signbit(value);
}

}  // namespace

Bytes RadianceGrid::Serialize() const {
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  parts_.options.Write(out);
  parts_.box.Write(out);
  out.Put(parts_.iteration);
  out.Put(parts_.radiance_scale);
  std::vector<uint32_t> cells;
  std::vector<float> radiance, weight;
  for (uint32_t cell = 0; cell < cell_count(); ++cell) {
    const auto of_cell = [&](const std::vector<float>& all) {
      return std::span(all).subspan(Entry(cell, 0), direction_count());
    };
    const auto weights = of_cell(parts_.weight), radiances = of_cell(parts_.radiance);
    if (std::all_of(weights.begin(), weights.end(), [](float w) { return w == 0; })) continue;
    cells.push_back(cell);
    weight.insert(weight.end(), weights.begin(), weights.end());
    radiance.insert(radiance.end(), radiances.begin(), radiances.end());
  }
  out.PutVector(cells);
  out.PutVector(radiance);
  out.PutVector(weight);
  return out.Take();
}

std::shared_ptr<const RadianceGrid> RadianceGrid::Parse(std::string_view bytes) {
  ByteReader in(bytes, "radiance grid");
  in.ExpectHeader(kMagic, kVersion);
  GridParts parts;
  parts.options = GridOptions::Read(in);
  parts.box = GuideBox::Read(in);
  parts.iteration = in.Get<uint32_t>();
  parts.radiance_scale = ReadRadianceScale(in);

  const auto cells = in.GetVector<uint32_t>();
  const auto radiance = in.GetVector<float>(), weight = in.GetVector<float>();
  const size_t directions = parts.options.direction_count();
  if (cells.size() > parts.options.cell_count() || radiance.size() != cells.size() * directions ||
      weight.size() != radiance.size())
    in.Fail("has arrays of lengths that do not fit");
  in.ExpectEnd();
  parts.radiance.assign(parts.options.cell_count() * directions, 0);
  parts.weight.assign(parts.radiance.size(), 0);
  for (size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] >= parts.options.cell_count() || (i > 0 && cells[i] <= cells[i - 1]))
      in.Fail("names a voxel that it does not have");
    bool known = false;
    for (size_t d = 0; d < directions; ++d) {
      const float r = radiance[i * directions + d], w = weight[i * directions + d];
      if (!Canonical(r, 3.4e38f) || !Canonical(w, 1) || (w == 0 && r != 0)) in.Fail("has an impossible entry");
      known |= w > 0;
      parts.radiance[cells[i] * directions + d] = r;
      parts.weight[cells[i] * directions + d] = w;
    }
    if (!known) in.Fail("has a voxel of which nothing is known");
  }
  return std::make_shared<const RadianceGrid>(std::move(parts));
}

}  // namespace lodestar
