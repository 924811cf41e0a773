// The pictures of `inspect --guide`, written into a folder and described for --json.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "client/guide_canvas.h"
#include "core/guiding/focal_field.h"
#include "core/guiding/product_lobes.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/guide_file.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/feature_pass.h"

namespace lodestar {

// NAME.png each; what was drawn is kept as {"name", "file", "size" [w, h], "grid" [w, h], "min", "max", "mean"} of the
// values, and "integral" over the sphere for densities.
class PictureFolder {
 public:
  explicit PictureFolder(std::filesystem::path folder);  // makes it; throws Error(kIo)
  void Draw(const std::string& name, const FloatGrid& grid, const PictureStyle& style);
  // A density per steradian in both maps of the sphere: NAME.png, the cylindrical square, and NAME-latlong.png.
  void DrawDensity(const std::string& name, const std::string& title, const std::function<float(Vec3)>& density);
  // A D-tree the same way; its square is exact. Colours are those of `like`, so that trees can be compared.
  void DrawTree(const std::string& name, const std::string& title, const DirectionalNode* nodes,
                const DirectionalNode* like);
  const nlohmann::json& pictures() const { return pictures_; }

 private:
  void DrawSphereMap(const std::string& name, const std::string& title, SphereMap map, const FloatGrid& grid,
                     const LogScale& scale);

  std::filesystem::path folder_;
  nlohmann::json pictures_ = nlohmann::json::array();
};

// Where a guide is looked at.
struct GuidePoint {
  Vec3 p;
  std::optional<ProductLobes> lobes;  // of the surface there, where it is known
  std::optional<SurfaceHit> surface;  // ... from a scene
};

struct GuideView {
  std::string label;                      // of the method, for titles
  Bounds3 bounds;                         // of the scene
  std::optional<GuidePoint> point;        // none: pictures of the whole alone
  std::shared_ptr<const Scene> scene;     // where one was given
  std::optional<LogScale> density_scale;  // of focal projections
};

// Slices through the point (the middle of the bounds without one), coloured by mean flux and by records. At a point its
// D-tree; where the file holds training records, also as it was rebuilt from them without reconstruction, and by both
// methods of reconstruction; with a surface, lobes, their product with the tree, and the BSDF.
void DrawSdTree(const SdTreeState& state, const GuideFile& file, const GuideView& view, PictureFolder* out);
// Projections along the axes and from the scene's camera; at a point the density of directions, and the BSDF's.
void DrawFocal(const FocalField& field, const GuideView& view, PictureFolder* out);

// At a point the radiances of its voxel, normalised to a density.
void DrawGrid(const RadianceGrid& grid, const GuideView& view, PictureFolder* out);

// How a technique goes on from a surface: a direction in world space, and f cos over its density; nothing where the
// sample failed.
struct TechniqueSample {
  Vec3 w;
  Rgb weight;
};
using Technique = std::function<std::optional<TechniqueSample>(const SurfaceHit&, float u_choice, Vec2 u)>;

// Where a technique leads from the view's surface (Sadek 2025, section 3.8.2): 4096 paths of up to three segments.
// NAME-x, -y, -z: how many segments pass each pixel of a view along that axis. NAME-light-x, ...: every segment counts
// by the light that comes along it and is reflected by the surface, so that only those show that lead to some.
void DrawRays(const std::string& name, const std::string& title, const GuideView& view, const Technique& technique,
              PictureFolder* out);

// The D-tree that `state` has at p, made once more from the records it came from by each method: "rebuilt" (no
// reconstruction), "dense", and "native" where the records were kept in two halves. Empty where the file has no
// records, or the leaf too few to have been rebuilt.
struct RemadeTree {
  std::string name;
  directional::Tree tree;
};
std::vector<RemadeTree> RemakeTrees(const GuideFile& file, Vec3 p);

}  // namespace lodestar
