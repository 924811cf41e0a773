// The focal field's bytes, version 1. An octree is the masks of its nodes, breadth first, and the masses of its leaves:
// no links are written and none can be wrong.
#include "core/guiding/bsdf_fraction.h"
#include "core/guiding/focal_field.h"
#include "core/guiding/radiance_scale.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("FOCL");
constexpr uint32_t kVersion = 1;

}  // namespace

FocalParts PartsOf(const FocalField& field) {
  FocalParts parts;
  parts.options = field.options();
  parts.box = {field.corner(), field.sides()};
  parts.iteration = field.iteration();
  parts.radiance_scale = field.radiance_scale();
  parts.weight = field.weight();
  for (const FocalOctree& octree : field.octrees()) {
    FocalParts::Octree& out = parts.octrees.emplace_back();
    for (uint32_t i = 0; i < octree.node_count(); ++i) {
      const FocalOctree::Node& node = octree.node(i);
      out.inner.push_back(node.inner);
      for (uint32_t c = 0; c < 8; ++c)
        if (((node.inner >> c) & 1) == 0) out.leaf_masses.push_back(octree.mass(i * 8 + c));
    }
  }
  parts.fractions.assign(field.fractions().begin(), field.fractions().end());
  return parts;
}

Bytes FocalField::Serialize() const {
  const FocalParts parts = PartsOf(*this);
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  parts.options.Write(out);
  parts.box.Write(out);
  out.Put(parts.iteration);
  out.Put(parts.radiance_scale);
  out.Put(parts.weight);
  for (const FocalParts::Octree& octree : parts.octrees) {
    out.PutVector(octree.inner);
    out.PutVector(octree.leaf_masses);
  }
  out.PutVector(parts.fractions);
  return out.Take();
}

std::shared_ptr<const FocalField> FocalField::Parse(std::string_view bytes) {
  ByteReader in(bytes, "focal field");
  in.ExpectHeader(kMagic, kVersion);
  FocalParts parts;
  parts.options = FocalOptions::Read(in);
  parts.box = GuideBox::Read(in);
  parts.iteration = in.Get<uint32_t>();
  parts.radiance_scale = ReadRadianceScale(in);
  parts.weight = in.Get<double>();
  if (!(parts.weight >= 0) || std::signbit(parts.weight) || !std::isfinite(parts.weight))
    in.Fail("has an invalid weight");

  double mass = 0;
  for (int i = 0; i < (parts.options.diverging ? 2 : 1); ++i) {
    FocalParts::Octree& octree = parts.octrees.emplace_back();
    octree.inner = in.GetVector<uint8_t>();
    octree.leaf_masses = in.GetVector<float>();
    for (const float leaf : octree.leaf_masses) {
      if (!(leaf >= 0 && leaf <= 1) || std::signbit(leaf)) in.Fail("has a voxel of impossible mass");
      mass += leaf;
    }
    if (octree.inner.size() > parts.options.max_nodes || !FocalOctree::From(octree.inner, octree.leaf_masses))
      in.Fail("has a broken octree");
  }
  if (!(mass > 0.99 && mass < 1.01)) in.Fail("has masses that are no distribution");
  parts.fractions = in.GetVector<float>();
  const size_t cells = parts.options.learn_fraction ? kFractionCells * kFractionCells * kFractionCells : 1;
  if (parts.fractions.size() != cells) in.Fail("has a wrong number of cells");
  for (const float fraction : parts.fractions) {
    if (!(fraction >= kMinBsdfFraction && fraction <= kMaxBsdfFraction)) in.Fail("has an invalid BSDF fraction");
  }
  in.ExpectEnd();
  return std::make_shared<const FocalField>(std::move(parts));
}

}  // namespace lodestar
