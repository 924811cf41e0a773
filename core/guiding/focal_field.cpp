#include "core/guiding/focal_field.h"

#include "core/base/check.h"
#include "core/base/hash.h"

namespace lodestar {
namespace {

constexpr double kTwoToMinus24 = 0x1p-24;  // the step of a random number

FocalParts::Octree UniformOctree(int depth) {
  FocalParts::Octree octree;
  size_t nodes = 1;
  for (int level = 1; level <= depth; ++level, nodes *= 8)
    octree.inner.insert(octree.inner.end(), nodes, level < depth ? 0xff : 0);
  octree.leaf_masses.assign(nodes, 1 / static_cast<float>(nodes));
  return octree;
}

}  // namespace

std::shared_ptr<const FocalField> FocalField::Initial(const Bounds3& bounds, const FocalOptions& options) {
  options.Validate();
  FocalParts parts;
  parts.options = options;
  parts.box = GuideBox::Around(bounds, "focal guiding");
  parts.octrees.push_back(UniformOctree(options.start_depth));
  if (options.diverging) {
    for (float& mass : parts.octrees[0].leaf_masses) mass *= 0.5f;
    parts.octrees.push_back(parts.octrees[0]);
  }
  const size_t cells = options.learn_fraction ? kFractionCells * kFractionCells * kFractionCells : 1;
  parts.fractions.assign(cells, options.bsdf_fraction);
  return std::make_shared<const FocalField>(std::move(parts));
}

FocalField::FocalField(FocalParts parts)
    : options_(parts.options),
      corner_(parts.box.corner),
      sides_(parts.box.sides),
      longest_(MaxComponent(parts.box.sides)),
      iteration_(parts.iteration),
      radiance_scale_(parts.radiance_scale),
      weight_(parts.weight),
      fractions_(std::move(parts.fractions)) {
  LODESTAR_CHECK(parts.octrees.size() == (options_.diverging ? 2u : 1u));
  double volume = 1;  // of the box, in cubes of its longest side
  for (int axis = 0; axis < 3; ++axis) {
    per_side_[axis] = 1 / sides_[axis];
    stretch_[axis] = longest_ / sides_[axis];
    shape_[axis] = sides_[axis] / longest_;
    volume *= static_cast<double>(sides_[axis]) / longest_;
  }
  ByteWriter head;
  options_.Write(head);
  for (int axis = 0; axis < 3; ++axis) {
    head.Put(corner_[axis]);
    head.Put(sides_[axis]);
  }
  head.Put(iteration_);
  head.Put(radiance_scale_);
  head.Put(weight_);
  head.PutVector(fractions_);
  for (const FocalParts::Octree& octree : parts.octrees) {
    std::optional<FocalOctree> built = FocalOctree::From(octree.inner, octree.leaf_masses);
    LODESTAR_CHECK(built.has_value());
    mass_ += built->mass();
    octrees_.push_back(std::move(*built));
    head.PutVector(octree.inner);
    head.PutVector(octree.leaf_masses);
  }
  LODESTAR_CHECK(mass_ > 0);
  pdf_scale_ = static_cast<float>(1 / (3 * volume * mass_));
  fingerprint_ = 0x464f;
  const Bytes& bytes = head.bytes();
  for (size_t at = 0; at < bytes.size(); at += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<size_t>(8, bytes.size() - at));
    fingerprint_ = Mix64(fingerprint_ ^ word);
  }
}

Vec3 FocalField::Direction(Vec3 x, Vec2 u) const {
  const Vec3 from = ToUnit(x);
  double target = (u.x + u.y * kTwoToMinus24) * mass_;
  const bool diverging = octrees_.size() > 1 && target >= octrees_[0].mass();
  if (diverging) target -= octrees_[0].mass();
  const FocalOctree& octree = octrees_[diverging];
  const FocalOctree::Voxel voxel = octree.Choose(target);
  const auto towards = [&](Vec3 in_voxel) {
    const Vec3 d = voxel.lower + in_voxel * voxel.size - from;
    const Vec3 w = d * shape_;
    const float length = Length(w);
    if (!(length > 0)) return Vec3{0, 0, 1};  // x itself: any direction leads through its voxel
    return w * (diverging ? -1 / length : 1 / length);
  };
  const uint64_t bits = Mix64((uint64_t{std::bit_cast<uint32_t>(u.x)} << 32) | std::bit_cast<uint32_t>(u.y));
  const auto coordinate = [&](int shift) { return (static_cast<float>((bits >> shift) & 0x1fffff) + 0.5f) * 0x1p-21f; };
  Vec3 w = towards({coordinate(0), coordinate(21), coordinate(42)});
  // Near the voxel's border the direction may round to one that misses it, whose density is another: over many samples
  // that would bias what lies there. Such a sample moves to the voxel's middle, which a direction's bits cannot miss.
  if (!octree.Crosses(RayOf(x, diverging ? -w : w), voxel)) [[unlikely]]
    w = towards({0.5f, 0.5f, 0.5f});
  return w;
}

uint32_t FocalField::CellAt(Vec3 x) const {
  const Vec3 unit = ToUnit(x) * static_cast<float>(kFractionCells);
  uint32_t cell = 0;
  for (int axis = 2; axis >= 0; --axis) {
    // max first: it turns NaN into 0.
    const float clamped = std::min(std::max(0.0f, unit[axis]), static_cast<float>(kFractionCells - 1));
    cell = cell * kFractionCells + static_cast<uint32_t>(clamped);
  }
  return cell;
}

size_t FocalField::memory() const {
  size_t bytes = fractions_.size() * sizeof(float);
  for (const FocalOctree& octree : octrees_) bytes += octree.memory();
  return bytes;
}

}  // namespace lodestar
