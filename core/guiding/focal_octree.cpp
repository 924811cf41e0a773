#include "core/guiding/focal_octree.h"

#include <limits>

namespace lodestar {

std::optional<FocalOctree> FocalOctree::From(std::span<const uint8_t> inner, std::span<const float> leaf_masses) {
  if (inner.empty() || inner.size() > (size_t{1} << 28)) return std::nullopt;
  FocalOctree tree;
  tree.nodes_.resize(inner.size());
  tree.masses_.resize(inner.size() * 8);
  tree.ends_.resize(inner.size());

  // The shape, parents before children.
  size_t next = 1, next_leaf = 0;
  tree.nodes_[0].level = 1;
  tree.nodes_[0].half = 0.5f;
  for (size_t i = 0; i < inner.size(); ++i) {
    if (i >= next) return std::nullopt;  // no octant leads here
    Node& node = tree.nodes_[i];
    if (node.level > kMaxDepth) return std::nullopt;
    tree.depth_ = node.level;
    node.inner = inner[i];
    node.first_child = static_cast<uint32_t>(next);
    next += static_cast<size_t>(std::popcount(inner[i]));
    if (next > inner.size()) return std::nullopt;
    for (int octant = 0; octant < 8; ++octant) {
      if (((inner[i] >> octant) & 1) == 0) continue;
      Node& child = tree.nodes_[node.Child(octant)];
      child.level = static_cast<uint8_t>(node.level + 1);
      child.half = node.half / 2;
      for (int axis = 0; axis < 3; ++axis)
        child.corner[axis] = node.corner[axis] + (((octant >> axis) & 1) ? node.half : 0);
    }
    next_leaf += 8 - static_cast<size_t>(std::popcount(inner[i]));
  }
  if (next != inner.size() || next_leaf != leaf_masses.size()) return std::nullopt;

  // Masses and densities, children before parents.
  for (size_t i = inner.size(); i-- > 0;) {
    Node& node = tree.nodes_[i];
    const float per_volume = std::ldexp(1.0f, 3 * node.level);
    next_leaf -= 8 - static_cast<size_t>(std::popcount(node.inner));
    size_t leaf = next_leaf;
    for (int octant = 0; octant < 8; ++octant) {
      float& mass = tree.masses_[i * 8 + octant];
      if ((node.inner >> octant) & 1) {
        double sum = 0;
        for (int c = 0; c < 8; ++c) sum += tree.masses_[size_t{node.Child(octant)} * 8 + c];
        mass = static_cast<float>(sum);
        node.density[octant] = 0;
        node.live |= static_cast<uint8_t>((mass > 0) << octant);
      } else {
        mass = leaf_masses[leaf++];
        node.density[octant] = mass * per_volume;
      }
    }
  }
  for (size_t i = 0; i < inner.size(); ++i) {
    double end = 0;
    int last = 0;
    for (int c = 0; c < 8; ++c) {
      const float mass = tree.masses_[i * 8 + c];
      if (mass > 0) last = c;
      tree.ends_[i].end[c] = end += mass;
    }
    for (int c = last; c < 8; ++c) tree.ends_[i].end[c] = std::numeric_limits<double>::infinity();
  }
  for (int c = 0; c < 8; ++c) tree.mass_ += tree.masses_[c];
  return tree;
}

FocalOctree::Voxel FocalOctree::Choose(double target) const {
  Voxel voxel{0, {0, 0, 0}, 1};
  for (uint32_t index = 0;;) {
    // How many octants the target lies behind: no branch of eight that nothing could predict.
    const double* const end = ends_[index].end;
    const __m256d at = _mm256_set1_pd(target);
    const int behind = _mm256_movemask_pd(_mm256_cmp_pd(at, _mm256_load_pd(end), _CMP_GE_OQ)) |
                       _mm256_movemask_pd(_mm256_cmp_pd(at, _mm256_load_pd(end + 4), _CMP_GE_OQ)) << 4;
    const int octant = std::popcount(static_cast<unsigned>(behind));
    voxel.slot = index * 8 + static_cast<uint32_t>(octant);
    target = std::min(octant > 0 ? target - end[octant - 1] : target, static_cast<double>(masses_[voxel.slot]));
    voxel.size *= 0.5f;
    for (int axis = 0; axis < 3; ++axis) voxel.lower[axis] += static_cast<float>((octant >> axis) & 1) * voxel.size;
    if (((nodes_[index].inner >> octant) & 1) == 0) return voxel;
    index = nodes_[index].Child(octant);
  }
}

bool FocalOctree::Crosses(const FocalRay& ray, const Voxel& voxel) const {
  // As Walk() has it.
  const __m128 lower = _mm_setr_ps(voxel.lower.x, voxel.lower.y, voxel.lower.z, 0);
  const __m128 a = _mm_mul_ps(_mm_sub_ps(lower, ray.origin_), ray.inverse_);
  const __m128 b = _mm_mul_ps(_mm_sub_ps(_mm_add_ps(lower, _mm_set1_ps(voxel.size)), ray.origin_), ray.inverse_);
  alignas(16) float near[4], far[4];
  _mm_store_ps(near, _mm_min_ps(a, b));
  _mm_store_ps(far, _mm_max_ps(a, b));
  return std::max({near[0], near[1], near[2], 0.0f}) < std::min({far[0], far[1], far[2]});
}

}  // namespace lodestar
