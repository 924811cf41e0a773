#include "client/guide_pictures.h"

#include <algorithm>

#include "client/outputs.h"
#include "client/values.h"

namespace lodestar {
namespace {

constexpr int kTreeLevel = 9;            // squares of D-trees have 512 pixels a side
constexpr uint32_t kSphereHeight = 256;  // of all other pictures of the sphere

}  // namespace

PictureFolder::PictureFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  PrepareFolder(folder_ / "x.png");
}

void PictureFolder::Draw(const std::string& name, const FloatGrid& grid, const PictureStyle& style) {
  const std::filesystem::path file = folder_ / (name + ".png");
  const Canvas canvas = DrawPicture(grid, style);
  canvas.WritePng(file);
  double sum = 0;
  for (const float value : grid.values) sum += static_cast<double>(value);
  const auto [least, greatest] = std::minmax_element(grid.values.begin(), grid.values.end());
  pictures_.push_back({{"name", name},
                       {"file", file.string()},
                       {"size", {canvas.width(), canvas.height()}},
                       {"grid", {grid.width, grid.height}},
                       {"min", *least},
                       {"max", *greatest},
                       {"mean", sum / static_cast<double>(grid.values.size())}});
}

void PictureFolder::DrawSphereMap(const std::string& name, const std::string& title, SphereMap map,
                                  const FloatGrid& grid, const LogScale& scale) {
  const double integral = IntegrateSphere(map, grid);
  PictureStyle style;
  style.title = title;
  style.caption = std::string("1/sr.  right: phi from +X by +Y.  up: ") +
                  (map == SphereMap::kCylindrical ? "cos theta" : "theta") + ".  integral " + FormatNumber(integral);
  style.scale = scale;
  Draw(name, grid, style);
  pictures_.back()["integral"] = integral;
}

void PictureFolder::DrawDensity(const std::string& name, const std::string& title,
                                const std::function<float(Vec3)>& density) {
  const FloatGrid square = DrawSphere(SphereMap::kCylindrical, kSphereHeight, density);
  const LogScale scale = LogScale::Of(square);
  DrawSphereMap(name, title, SphereMap::kCylindrical, square, scale);
  DrawSphereMap(name + "-latlong", title, SphereMap::kLatLong, DrawSphere(SphereMap::kLatLong, kSphereHeight, density),
                scale);
}

void PictureFolder::DrawTree(const std::string& name, const std::string& title, const DirectionalNode* nodes,
                             const DirectionalNode* like) {
  const LogScale scale = LogScale::Of(DrawDirectionalTree(like, kTreeLevel));
  DrawSphereMap(name, title, SphereMap::kCylindrical, DrawDirectionalTree(nodes, kTreeLevel), scale);
  const auto density = [nodes](Vec3 w) { return directional::Locate(nodes, DirectionToCylindrical(w)).density; };
  DrawSphereMap(name + "-latlong", title, SphereMap::kLatLong, DrawSphere(SphereMap::kLatLong, kSphereHeight, density),
                scale);
}

}  // namespace lodestar
