#include "core/learning/contribution.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/check.h"
#include "core/base/sealed_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("LDCN");

bool Sound(const PixelSum& p) {
  return std::isfinite(p.r) && std::isfinite(p.g) && std::isfinite(p.b) && std::isfinite(p.luminance_squared) &&
         p.luminance_squared >= 0;
}

FilmTile ReadTile(ByteReader& in, const TileGrid& grid, uint32_t expected) {
  FilmTile tile;
  tile.tile = in.Get<uint32_t>();
  if (tile.tile != expected)
    in.Fail("holds tile " + std::to_string(tile.tile) + " where tile " + std::to_string(expected) + " belongs");
  tile.pixels = in.GetVector<PixelSum>();
  const TileRect rect = grid.Rect(tile.tile);
  if (tile.pixels.size() != rect.pixels()) {
    in.Fail("has " + std::to_string(tile.pixels.size()) + " pixels in tile " + std::to_string(tile.tile) +
            ", which has " + std::to_string(rect.pixels()));
  }
  const auto bad = std::find_if_not(tile.pixels.begin(), tile.pixels.end(), Sound);
  if (bad != tile.pixels.end()) {
    const auto at = static_cast<uint32_t>(bad - tile.pixels.begin());
    in.Fail("has a pixel sum that is not finite at x " + std::to_string(rect.x0 + at % rect.width()) + ", y " +
            std::to_string(rect.y0 + at / rect.width()));
  }
  return tile;
}

}  // namespace

void Contribution::Merge(Contribution&& other) {
  const bool append = tiles.empty() || other.tiles.empty() || tiles.back().tile < other.tiles.front().tile;
  const auto middle = static_cast<std::ptrdiff_t>(tiles.size());
  tiles.insert(tiles.end(), std::make_move_iterator(other.tiles.begin()), std::make_move_iterator(other.tiles.end()));
  if (!append) {
    std::inplace_merge(tiles.begin(), tiles.begin() + middle, tiles.end(),
                       [](const FilmTile& a, const FilmTile& b) { return a.tile < b.tile; });
    const auto twice = std::adjacent_find(tiles.begin(), tiles.end(),
                                          [](const FilmTile& a, const FilmTile& b) { return a.tile == b.tile; });
    LODESTAR_CHECK(twice == tiles.end());  // the same unit merged twice
  }
  if (!statistics) {
    statistics = std::move(other.statistics);
  } else if (other.statistics) {
    statistics->Merge(*other.statistics);
  }
  health.Merge(other.health);
  paths += other.paths;
  rays += other.rays;
  vertices += other.vertices;
  other = Contribution();
}

Bytes SerializeContribution(const Contribution& contribution) {
  ByteWriter out = OpenDocument(kMagic, kContributionVersion);
  out.Put<uint32_t>(static_cast<uint32_t>(contribution.tiles.size()));
  for (const FilmTile& tile : contribution.tiles) {
    out.Put(tile.tile);
    out.PutVector(tile.pixels);
  }
  contribution.health.Write(out);
  out.Put(contribution.paths);
  out.Put(contribution.rays);
  out.Put(contribution.vertices);
  out.Put<uint8_t>(contribution.statistics ? 1 : 0);
  if (contribution.statistics) out.PutString(contribution.statistics->Serialize());
  return Seal(std::move(out));
}

ReceivedContribution ReadContribution(const TileGrid& grid, const Round& round, std::span<const TreeNode> nodes,
                                      std::string_view bytes) {
  LODESTAR_CHECK(!nodes.empty());
  const std::string what = "contribution of " + nodes.front().ToString() +
                           (nodes.size() > 1 ? " and " + std::to_string(nodes.size() - 1) + " more" : "") +
                           " (iteration " + std::to_string(round.iteration) + ", round " + std::to_string(round.index) +
                           ")";
  ByteReader in(OpenSealed(bytes, kMagic, kContributionVersion, what), what);
  if (round.unit_count != grid.tile_count()) in.Fail("belongs to a round of another image size");
  uint32_t units = 0, end = 0;
  for (const TreeNode node : nodes) {
    if (!node.ValidIn(round.unit_count)) in.Fail("names a node that does not exist in its round");
    if (node.first() < end) in.Fail("names nodes that do not ascend");
    end = node.end(round.unit_count);
    units += end - node.first();
  }
  ReceivedContribution received;
  Contribution& rest = received.rest;
  if (in.Get<uint32_t>() != units) in.Fail("does not hold the " + std::to_string(units) + " tiles of its nodes");
  for (const TreeNode node : nodes) {
    for (uint32_t unit = node.first(); unit < node.end(round.unit_count); ++unit)
      rest.tiles.push_back(ReadTile(in, grid, unit));
  }
  rest.health = HealthReport::Read(in);
  rest.paths = in.Get<uint64_t>();
  rest.rays = in.Get<uint64_t>();
  rest.vertices = in.Get<uint64_t>();
  if (in.GetFlag()) {
    if (!round.record) in.Fail("carries statistics, but nothing is learned from its round");
    received.statistics = in.GetView();
  }
  in.ExpectEnd();
  return received;
}

}  // namespace lodestar
