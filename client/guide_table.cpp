#include "client/guide_table.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "client/values.h"

namespace lodestar {
namespace {

using Json = nlohmann::json;

Json Quantiles(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  double sum = 0;
  for (const double value : values) sum += value;
  return {{"min", values.front()}, {"p10", at(0.1)},       {"median", at(0.5)},
          {"p90", at(0.9)},        {"max", values.back()}, {"mean", sum / static_cast<double>(values.size())}};
}

std::string Line(const std::string& name, const std::string& text) {
  return name + std::string(name.size() < 22 ? 22 - name.size() : 1, ' ') + text + "\n";
}
std::string Line(const std::string& name, const Json& quantiles) {
  if (quantiles.is_null()) return Line(name, std::string("none"));
  std::string text;
  for (const char* key : {"min", "p10", "median", "p90", "max", "mean"})
    text += (text.empty() ? "" : "  ") + std::string(key) + " " + FormatNumber(quantiles[key].get<double>());
  return Line(name, text);
}
std::string Text(const Json& number) {
  return FormatNumber(number.get<double>());
}
// Whole numbers, all their digits.
std::string Count(const Json& number) {
  return number.dump();
}
std::string BytesOf(const Json& json, const char* key) {
  return FormatBytes(json[key].get<double>());
}

// The share of the mass in the densest voxels that fill a hundredth of the volume.
double MassInDensestHundredth(const FocalOctree& octree) {
  struct Voxel {
    double density, volume;
  };
  std::vector<Voxel> voxels;
  for (uint32_t i = 0; i < octree.node_count(); ++i) {
    const FocalOctree::Node& node = octree.node(i);
    const double volume = std::ldexp(1.0, -3 * node.level);
    for (int c = 0; c < 8; ++c) {
      if (!(node.inner & (1u << c))) voxels.push_back({node.density[static_cast<size_t>(c)], volume});
    }
  }
  std::sort(voxels.begin(), voxels.end(), [](const Voxel& a, const Voxel& b) { return a.density > b.density; });
  double left = 0.01, mass = 0;
  for (const Voxel& voxel : voxels) {
    const double taken = std::min(left, voxel.volume);
    mass += taken * voxel.density;
    left -= taken;
    if (!(left > 0)) break;
  }
  return octree.mass() > 0 ? mass / octree.mass() : 0;
}

const char* TargetName(SdTreeOptions::Target target) {
  switch (target) {
    case SdTreeOptions::Target::kRadiance:
      return "radiance";
    case SdTreeOptions::Target::kSimple:
      return "simple";
    case SdTreeOptions::Target::kFull:
      return "full";
    case SdTreeOptions::Target::kSwitching:
      return "switching";
  }
  return "";
}
const char* ReconstructionName(SdTreeOptions::Reconstruction reconstruction) {
  switch (reconstruction) {
    case SdTreeOptions::Reconstruction::kNone:
      return "none";
    case SdTreeOptions::Reconstruction::kDense:
      return "dense";
    case SdTreeOptions::Reconstruction::kNative:
      return "native";
    case SdTreeOptions::Reconstruction::kDenseUnlimited:
      return "dense-unlimited";
  }
  return "";
}

}  // namespace

Json DescribeSdTree(const SdTree& tree) {
  std::vector<double> spatial, records, nodes, depths, fractions, nee, flux;
  std::vector<uint64_t> histogram;
  uint32_t learned = 0;
  for (uint32_t i = 0; i < tree.leaf_count(); ++i) {
    const SdTreeLeaf& leaf = tree.leaf(i);
    spatial.push_back(tree.spatial().cell(i).depth);
    records.push_back(static_cast<double>(leaf.records));
    nodes.push_back(leaf.node_count);
    depths.push_back(leaf.depth);
    if (histogram.size() <= leaf.depth) histogram.resize(leaf.depth + 1u);
    ++histogram[leaf.depth];
    nee.push_back(static_cast<double>(leaf.nee_probability));
    if (!leaf.learned) continue;
    ++learned;
    fractions.push_back(static_cast<double>(leaf.bsdf_fraction));
    flux.push_back(static_cast<double>(leaf.mean_flux));
  }
  double record_sum = 0;
  for (const double r : records) record_sum += r;
  return {{"iteration", tree.iteration()},
          {"target", TargetName(tree.options().target)},
          {"reconstruction", ReconstructionName(tree.options().reconstruction)},
          {"memory_bytes", tree.memory()},
          {"spatial", {{"leaves", tree.leaf_count()}, {"learned", learned}, {"depth", Quantiles(std::move(spatial))}}},
          {"directional",
           {{"nodes", tree.node_count()},
            {"nodes_per_tree", Quantiles(std::move(nodes))},
            {"depth", Quantiles(std::move(depths))},
            {"histogram", histogram}}},
          {"records", {{"total", record_sum}, {"per_leaf", Quantiles(std::move(records))}}},
          {"bsdf_fraction", Quantiles(std::move(fractions))},
          {"nee_probability", Quantiles(std::move(nee))},
          {"mean_flux", Quantiles(std::move(flux))}};
}

Json DescribeFocal(const FocalField& field) {
  Json octrees = Json::array();
  for (size_t i = 0; i < field.octrees().size(); ++i) {
    const FocalOctree& octree = field.octrees()[i];
    std::vector<double> depths;
    std::vector<uint64_t> histogram;
    for (uint32_t n = 0; n < octree.node_count(); ++n) {
      const FocalOctree::Node& node = octree.node(n);
      const int leaves = 8 - std::popcount(node.inner);
      if (histogram.size() <= node.level) histogram.resize(node.level + 1u);
      histogram[node.level] += static_cast<uint64_t>(leaves);
      depths.insert(depths.end(), static_cast<size_t>(leaves), node.level);
    }
    octrees.push_back({{"kind", i == 0 ? "converging" : "diverging"},
                       {"nodes", octree.node_count()},
                       {"voxels", depths.size()},
                       {"depth", Quantiles(std::move(depths))},
                       {"histogram", histogram},
                       {"share_of_mass", field.mass() > 0 ? octree.mass() / field.mass() : 0},
                       {"mass_in_densest_hundredth", MassInDensestHundredth(octree)}});
  }
  return {{"iteration", field.iteration()},
          {"learned", field.HasLearned()},
          {"memory_bytes", field.memory()},
          {"octrees", octrees},
          {"bsdf_fraction", Quantiles({field.fractions().begin(), field.fractions().end()})}};
}

Json DescribeGrid(const RadianceGrid& grid) {
  uint64_t known = 0, known_cells = 0;
  std::vector<double> fluence;
  for (uint32_t cell = 0; cell < grid.cell_count(); ++cell) {
    uint64_t in_cell = 0;
    for (uint32_t direction = 0; direction < grid.direction_count(); ++direction)
      in_cell += grid.parts().weight[grid.Entry(cell, direction)] > 0;
    known += in_cell;
    known_cells += in_cell > 0;
    if (in_cell > 0) fluence.push_back(static_cast<double>(grid.Fluence(cell)));
  }
  return {{"iteration", grid.iteration()},
          {"voxels", grid.cell_count()},
          {"known_voxels", known_cells},
          {"directions", grid.direction_count()},
          {"entries", uint64_t{grid.cell_count()} * grid.direction_count()},
          {"known_entries", known},
          {"mean_flux", Quantiles(std::move(fluence))}};
}

std::string SdTreeTable(const Json& d) {
  std::string histogram;
  const Json& depths = d["directional"]["histogram"];
  for (size_t depth = 0; depth < depths.size(); ++depth) {
    if (depths[depth] != 0)
      histogram += (histogram.empty() ? "" : "  ") + std::to_string(depth) + ": " + Count(depths[depth]);
  }
  return Line("target", d["target"].get<std::string>() + ", reconstruction " + d["reconstruction"].get<std::string>()) +
         Line("spatial leaves",
              Count(d["spatial"]["leaves"]) + ", " + Count(d["spatial"]["learned"]) + " with a learned D-tree") +
         Line("spatial depth", d["spatial"]["depth"]) +
         Line("D-tree nodes", Count(d["directional"]["nodes"]) + ", " + BytesOf(d, "memory_bytes") + " with all else") +
         Line("nodes per D-tree", d["directional"]["nodes_per_tree"]) +
         Line("D-tree depth", d["directional"]["depth"]) + Line("D-trees by depth", histogram) +
         Line("records", FormatCount(d["records"]["total"].get<double>())) +
         Line("records per leaf", d["records"]["per_leaf"]) + Line("BSDF fraction", d["bsdf_fraction"]) +
         Line("light-sample share", d["nee_probability"]) + Line("mean flux", d["mean_flux"]);
}

std::string FocalTable(const Json& d) {
  std::string text = Line("memory", BytesOf(d, "memory_bytes"));
  for (const Json& octree : d["octrees"]) {
    const std::string kind = octree["kind"].get<std::string>();
    text +=
        Line(kind, Count(octree["nodes"]) + " nodes, " + Count(octree["voxels"]) + " voxels, " +
                       Text(100 * octree["share_of_mass"].get<double>()) + " % of the mass") +
        Line("voxel depth", octree["depth"]) +
        Line("densest 1 % of space", Text(100 * octree["mass_in_densest_hundredth"].get<double>()) + " % of its mass");
  }
  return text + Line("BSDF fraction", d["bsdf_fraction"]);
}

std::string GridTable(const Json& d) {
  return Line("voxels", Count(d["voxels"]) + ", something known of " + Count(d["known_voxels"])) +
         Line("entries", Count(d["entries"]) + ", " + Count(d["directions"]) +
                             " directions a voxel, something known of " + Count(d["known_entries"])) +
         Line("mean flux", d["mean_flux"]);
}

}  // namespace lodestar
