// The SD-tree's bytes, version 3.
#include <numeric>

#include "core/guiding/bsdf_fraction.h"
#include "core/guiding/directional_tree_io.h"
#include "core/guiding/light_selection.h"
#include "core/guiding/radiance_scale.h"
#include "core/guiding/sd_tree.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("DSDT");
constexpr uint32_t kVersion = 3;

// Probabilities in units of 2^-16.
bool IsSelection(std::span<const uint16_t> shares) {
  return std::find(shares.begin(), shares.end(), 0) == shares.end() &&
         std::accumulate(shares.begin(), shares.end(), 0u) == 65536;
}

}  // namespace

Bytes SdTree::Serialize() const {
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  options_.Write(out);
  for (int axis = 0; axis < 3; ++axis) out.Put(spatial_.corner()[axis]);
  out.Put(spatial_.size());
  out.Put(iteration_);
  out.Put(radiance_scale_);
  std::vector<uint8_t> depths, learned, masks(nodes_.size());
  std::vector<uint32_t> counts;
  std::vector<float> fractions, records, flux, nee;
  for (uint32_t i = 0; i < leaf_count(); ++i) {
    depths.push_back(static_cast<uint8_t>(spatial_.cell(i).depth));
    learned.push_back(leaves_[i].learned);
    counts.push_back(leaves_[i].node_count);
    fractions.push_back(leaves_[i].bsdf_fraction);
    records.push_back(leaves_[i].records);
    flux.push_back(leaves_[i].mean_flux);
    nee.push_back(leaves_[i].nee_probability);
  }
  std::vector<uint16_t> probabilities(nodes_.size() * 3);
  for (size_t i = 0; i < nodes_.size(); ++i) {
    masks[i] = directional::ChildMask(nodes_[i]);
    probabilities[i * 3] = nodes_[i].left;
    probabilities[i * 3 + 1] = nodes_[i].lower[0];
    probabilities[i * 3 + 2] = nodes_[i].lower[1];
  }
  out.PutVector(depths);
  out.PutVector(learned);
  out.PutVector(counts);
  out.PutVector(fractions);
  out.PutVector(records);
  out.PutVector(flux);
  out.PutVector(nee);
  out.PutVector(masks);
  out.PutVector(probabilities);
  out.PutVector(lights_by_power_);
  out.PutVector(lights_);
  return out.Take();
}

std::shared_ptr<const SdTree> SdTree::Parse(std::string_view bytes) {
  ByteReader in(bytes, "SD-tree");
  in.ExpectHeader(kMagic, kVersion);
  SdTreeParts parts;
  parts.options = SdTreeOptions::Read(in);
  for (int axis = 0; axis < 3; ++axis) parts.corner[axis] = in.Get<float>();
  parts.size = in.Get<float>();
  if (!IsFinite(parts.corner) || !(parts.size >= 1e-30f && parts.size <= 1e30f)) in.Fail("has invalid bounds");
  parts.iteration = in.Get<uint32_t>();
  parts.radiance_scale = ReadRadianceScale(in);

  parts.depths = in.GetVector<uint8_t>();
  const auto learned = in.GetVector<uint8_t>();
  const auto counts = in.GetVector<uint32_t>();
  const auto fractions = in.GetVector<float>();
  const auto records = in.GetVector<float>();
  const auto flux = in.GetVector<float>();
  const auto nee = in.GetVector<float>();
  const auto masks = in.GetVector<uint8_t>();
  const std::string_view probabilities = in.GetVectorBytes(sizeof(uint16_t));
  parts.lights_by_power = in.GetVector<uint16_t>();
  parts.lights = in.GetVector<uint16_t>();
  in.ExpectEnd();
  const size_t leaves = parts.depths.size();
  if (learned.size() != leaves || counts.size() != leaves || fractions.size() != leaves || records.size() != leaves ||
      flux.size() != leaves || nee.size() != leaves || probabilities.size() != masks.size() * 3 * sizeof(uint16_t)) {
    in.Fail("has arrays of different lengths");
  }
  const size_t groups = parts.lights_by_power.size();
  if (groups == 1 || groups > kMostLightGroups || parts.lights.size() != leaves * groups)
    in.Fail("has light probabilities of another number");
  if (groups > 0) {
    if (!IsSelection(parts.lights_by_power)) in.Fail("has light probabilities that are no distribution");
    for (size_t i = 0; i < leaves; ++i) {
      if (!IsSelection(std::span(parts.lights).subspan(i * groups, groups)))
        in.Fail("has light probabilities that are no distribution");
    }
  }
  if (!SpatialTree::FromDepths(parts.corner, parts.size, parts.depths)) in.Fail("has a broken spatial tree");
  if (masks.size() > (uint64_t{1} << 29)) in.Fail("has too many nodes");

  parts.nodes.resize(masks.size());
  for (size_t i = 0; i < masks.size(); ++i) {
    if (masks[i] > 15 ||
        !directional::ReadProbabilities(probabilities.data() + i * directional::kProbabilityBytes, &parts.nodes[i]))
      in.Fail("has a node that is no distribution");
  }
  parts.leaves.resize(leaves);
  uint64_t first = 0;
  for (size_t i = 0; i < leaves; ++i) {
    if (counts[i] == 0 || counts[i] > directional::kMaxNodes || counts[i] > masks.size() - first)
      in.Fail("has a directional tree beyond its nodes");
    const int depth =
        directional::Link(std::span(parts.nodes).subspan(first, counts[i]), std::span(masks).subspan(first, counts[i]),
                          parts.options.max_directional_depth);
    if (depth == 0) in.Fail("has a broken directional tree");
    if (learned[i] > 1 || !(fractions[i] >= kMinBsdfFraction && fractions[i] <= kMaxBsdfFraction) ||
        !(records[i] >= 0) || !std::isfinite(records[i]) || !(flux[i] >= 0) || !std::isfinite(flux[i]) ||
        !(nee[i] > 0 && nee[i] <= 1)) {
      in.Fail("has an invalid leaf");
    }
    parts.leaves[i] = {static_cast<uint32_t>(first), counts[i], fractions[i], records[i], flux[i], nee[i], learned[i],
                       static_cast<uint8_t>(depth)};
    first += counts[i];
  }
  if (first != masks.size()) in.Fail("has nodes of no tree");
  return std::make_shared<const SdTree>(std::move(parts));
}

}  // namespace lodestar
