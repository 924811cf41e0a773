#include "client/guide_pictures.h"
#include "client/values.h"
#include "core/guiding/guide_picture_space.h"
#include "core/guiding/product_distribution.h"
#include "core/guiding/sd_tree_advance.h"

namespace lodestar {
namespace {

constexpr uint32_t kSlicePixels = 512;
constexpr char kAxes[] = "XYZ";

std::string At(Vec3 p) {
  return "at " + FormatNumber(p.x) + ", " + FormatNumber(p.y) + ", " + FormatNumber(p.z);
}

void DrawSlices(const SdTree& tree, const GuideView& view, PictureFolder* out) {
  const Vec3 p = view.point ? view.point->p : view.bounds.Center();
  const Bounds3 window = PictureWindow(view.bounds);
  for (int axis = 0; axis < 3; ++axis) {
    const LeafPicture picture = DrawLeaves(tree.spatial(), axis, p, window, kSlicePixels);
    PictureStyle style;
    style.borders.resize(picture.leaves.size());
    for (uint32_t y = 0; y < picture.height; ++y) {
      for (uint32_t x = 0; x < picture.width; ++x) style.borders[size_t{y} * picture.width + x] = picture.Border(x, y);
    }
    const int right = RightAxis(axis), up = UpAxis(axis);
    const auto along = [&](int a) { return (p[a] - window.min[a]) / (window.max[a] - window.min[a]); };
    if (view.point) {
      style.marker = {along(right) * static_cast<float>(picture.width),
                      (1 - along(up)) * static_cast<float>(picture.height)};
    }
    const std::string where = std::string(1, kAxes[axis]) + " = " + FormatNumber(p[axis]);
    const std::string axes = std::string(".  right: ") + kAxes[right] + ".  up: " + kAxes[up];
    const std::string name(1, static_cast<char>('x' + axis));
    style.title = "mean flux, " + where;
    style.caption = "incident radiance over the sphere" + axes;
    out->Draw("flux-" + name, picture.Of([&](uint32_t leaf) { return tree.leaf(leaf).mean_flux; }), style);
    style.title = "records, " + where;
    style.caption = "records of a leaf in the last iteration" + axes;
    out->Draw("records-" + name, picture.Of([&](uint32_t leaf) { return tree.leaf(leaf).records; }), style);
  }
}

void DrawProduct(const ProductLobes& lobes, const std::string& at, const DirectionalNode* nodes, PictureFolder* out) {
  if (lobes.none()) return;
  out->DrawDensity("lobes", "lobes " + at, [&](Vec3 w) { return lobes.Density(w); });
  const TreeTop top(nodes);
  const ProductDistribution product(nodes, top, lobes);
  if (!product.usable()) return;
  out->DrawDensity("product", "product " + at, [&](Vec3 w) { return product.Pdf(w); });
  // What it stands for, normalised by its own integral.
  const auto exact = [&](Vec3 w) {
    return lobes.Density(w) * directional::Locate(nodes, DirectionToCylindrical(w)).density;
  };
  const double integral = IntegrateSphere(SphereMap::kLatLong, DrawSphere(SphereMap::kLatLong, 256, exact));
  if (!(integral > 0)) return;
  const float scale = static_cast<float>(1 / integral);
  out->DrawDensity("product-exact", "lobes x tree " + at, [&](Vec3 w) { return exact(w) * scale; });
}

}  // namespace

std::vector<RemadeTree> RemakeTrees(const GuideFile& file, Vec3 p) {
  if (!file.training) return {};
  const auto before = SdTreeState::Parse(file.training->state);
  const SdTree& tree = before->tree();
  SdTreeStatistics statistics(before->shared_tree());
  statistics.MergeSerialized(file.training->statistics);
  const uint32_t leaf = tree.LeafAt(p);
  const SdTreeOptions& options = tree.options();
  if (statistics.leaf(leaf).records() < static_cast<double>(options.min_records)) return {};
  directional::CellMasses masses = RecordedMasses(tree, statistics, leaf);
  double total = 0;
  for (const double mass : masses.total) total += mass;
  if (!(total > 0)) return {};
  const double threshold = static_cast<double>(options.flux_threshold);
  const int depth = options.max_directional_depth;
  std::vector<RemadeTree> trees;
  if (!masses.halves[0].empty()) trees.push_back({"native", directional::ReconstructNative(masses, threshold, depth)});
  trees.push_back({"dense", directional::ReconstructDense(masses, options.dense_sigma, threshold, depth)});
  trees.push_back(
      {"rebuilt", directional::Rebuild(masses.nodes, masses.node_count, std::move(masses.total), threshold, depth)});
  return trees;
}

void DrawSdTree(const SdTreeState& state, const GuideFile& file, const GuideView& view, PictureFolder* out) {
  const SdTree& tree = state.tree();
  DrawSlices(tree, view, out);
  if (!view.point) return;
  const GuidePoint& point = *view.point;
  const DirectionalNode* const nodes = tree.Tree(tree.LeafAt(point.p));
  out->DrawTree("dtree", "D-tree " + At(point.p), nodes, nodes);
  for (const RemadeTree& remade : RemakeTrees(file, point.p)) {
    const std::string title = remade.name == "rebuilt" ? "not reconstructed" : "reconstructed, " + remade.name;
    out->DrawTree("dtree-" + remade.name, "D-tree " + title, remade.tree.nodes.data(), nodes);
  }
  if (point.lobes) DrawProduct(*point.lobes, At(point.p), nodes, out);
}

}  // namespace lodestar
