// A density over the unit cube, constant in each voxel of an octree, as directions are drawn from it: a voxel by its
// mass, a point in it uniformly, and the direction towards that point (Rath et al. 2023, section 4; Sadek 2025, 2.6.3).
//
// A node holds eight octants (bit 0: upper half in x, 1: y, 2: z), each a leaf voxel or another node. Nodes lie breadth
// first, so that the masks of which octants are nodes say everything about the shape. The root is always a node.
//
// All of a ray's voxels are found by one loop over nodes, eight octants at a time: three planes along each axis give
// the parameters at which the ray enters and leaves every octant, as two vectors of eight floats. A plane's parameter
// is computed alike wherever it is met, so a ray's intervals tile it exactly: no gap, no overlap. The order in which
// voxels are met does not matter to a sum, so nothing is sorted (Sadek 2025, 3.3.2) and no branch depends on it.
#pragma once

#include <immintrin.h>

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace lodestar {

// A ray in the octree's coordinates, prepared for walking: origin + t * direction, t >= 0. Components of the direction
// below 1e-18 count as 1e-18 of their sign, so that every plane has a parameter and none is 0/0.
class FocalRay {
 public:
  FocalRay(Vec3 origin, Vec3 direction)
      : origin_(_mm_setr_ps(origin.x, origin.y, origin.z, 0)),
        inverse_(_mm_setr_ps(Inverse(direction.x), Inverse(direction.y), Inverse(direction.z), 0)) {
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    for (int axis = 0; axis < 3; ++axis) {
      const int negative = std::signbit(direction[axis]);
      // In lane c: axis, plus 4 where the octant lies behind the middle plane as the ray goes.
      const __m256i upper = _mm256_and_si256(_mm256_srli_epi32(lane, axis), _mm256_set1_epi32(1));
      const __m256i behind = _mm256_xor_si256(upper, _mm256_set1_epi32(negative));
      select_[axis] = _mm256_add_epi32(_mm256_set1_epi32(axis), _mm256_slli_epi32(behind, 2));
    }
  }

 private:
  friend class FocalOctree;
  static float Inverse(float d) { return 1 / (std::fabs(d) < 1e-18f ? std::copysign(1e-18f, d) : d); }

  __m128 origin_, inverse_;
  __m256i select_[3];
};

class FocalOctree {
 public:
  static constexpr int kMaxDepth = 16;  // a voxel is then 256 steps of a float wide

  struct Node {
    std::array<float, 8> density;  // of leaves: mass / volume, with the cube's volume 1; 0 for nodes
    uint32_t first_child;          // where its octants that are nodes begin, in order
    uint8_t inner;                 // bit c: octant c is a node
    uint8_t live;                  // ... of positive mass
    uint8_t level;                 // of its octants: 1 at the root
    uint32_t Child(int octant) const {
      return first_child + static_cast<uint32_t>(std::popcount(inner & ((1u << octant) - 1)));
    }
  };
  struct Voxel {
    uint32_t slot;  // node * 8 + octant
    Vec3 lower;
    float size;
  };

  FocalOctree() = default;
  // `inner` of every node, breadth first, and the masses of the leaves in the order of their slots: not negative, their
  // sum finite. Nothing where the masks form no octree of at most kMaxDepth levels (corrupt bytes).
  static std::optional<FocalOctree> From(std::span<const uint8_t> inner, std::span<const float> leaf_masses);

  // The voxel that holds the share `target` in [0, mass()) of the mass. Never one of mass zero, unless all are.
  Voxel Choose(double target) const;

  // The sum over all voxels on the ray of density * (t1^3 - t0^3): with the point uniform in its voxel, a third of this
  // is the density of its direction seen from the ray's origin, where the cube has volume and mass 1.
  float Integrate(const FocalRay& ray) const {
    __m256 sum = _mm256_setzero_ps();
    Walk<true>(ray, kInfinity, [&](uint32_t, const Node& node, int, __m256 valid, __m256 t0, __m256 t1) {
      // (t1 - t0)(t1^2 + t1 t0 + t0^2): the difference of cubes cancels for far, thin voxels.
      const __m256 squares = _mm256_add_ps(_mm256_mul_ps(t1, _mm256_add_ps(t1, t0)), _mm256_mul_ps(t0, t0));
      const __m256 cubes = _mm256_mul_ps(_mm256_sub_ps(t1, t0), squares);
      sum = _mm256_add_ps(sum, _mm256_and_ps(valid, _mm256_mul_ps(_mm256_loadu_ps(node.density.data()), cubes)));
    });
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
  }

  // Calls visit(slot, t0, t1, density) for every leaf voxel that the ray crosses before t_end, t0 < t1, in no order.
  template <class Visit>
  void ForVoxels(const FocalRay& ray, float t_end, Visit&& visit) const {
    Walk<false>(ray, t_end, [&](uint32_t index, const Node& node, int hit, __m256, __m256 near, __m256 far) {
      alignas(32) float t0[8], t1[8];
      _mm256_store_ps(t0, near);
      _mm256_store_ps(t1, far);
      for (unsigned leaves = static_cast<unsigned>(hit) & ~node.inner; leaves != 0; leaves &= leaves - 1) {
        const int octant = std::countr_zero(leaves);
        visit(index * 8 + static_cast<uint32_t>(octant), t0[octant], t1[octant], node.density[octant]);
      }
    });
  }

  // Whether the walk along this ray meets the voxel.
  bool Crosses(const FocalRay& ray, const Voxel& voxel) const;

  double mass() const { return mass_; }
  uint32_t node_count() const { return static_cast<uint32_t>(nodes_.size()); }
  int depth() const { return depth_; }
  const Node& node(uint32_t index) const { return nodes_[index]; }
  // Of an octant, with all that lies in it.
  float mass(uint32_t slot) const { return masses_[slot]; }
  size_t memory() const { return nodes_.size() * sizeof(Node) + masses_.size() * sizeof(float); }

 private:
  template <bool kLiveOnly, class Visit>
  void Walk(const FocalRay& ray, float t_end, Visit&& visit) const;

  std::vector<Node> nodes_;
  std::vector<float> masses_;  // by slot
  double mass_ = 0;
  int depth_ = 0;
};

template <bool kLiveOnly, class Visit>
inline void FocalOctree::Walk(const FocalRay& ray, float t_end, Visit&& visit) const {
  // From a node's lower corner (x, y, z, half its size) to that of an octant, in units of the half.
  alignas(16) static constexpr float kOffset[8][4] = {{0, 0, 0, -0.5f}, {1, 0, 0, -0.5f}, {0, 1, 0, -0.5f},
                                                      {1, 1, 0, -0.5f}, {0, 0, 1, -0.5f}, {1, 0, 1, -0.5f},
                                                      {0, 1, 1, -0.5f}, {1, 1, 1, -0.5f}};
  // A ray crosses at most four octants of a node, and one of them is walked next.
  struct Pending {
    __m128 corner;
    uint32_t node;
  };
  std::array<Pending, 3 * kMaxDepth + 4> stack;
  size_t waiting = 0;
  const __m256 start = _mm256_setzero_ps(), end = _mm256_set1_ps(t_end);
  __m128 corner = _mm_setr_ps(0, 0, 0, 0.5f);
  uint32_t index = 0;
  for (;;) {
    const Node& node = nodes_[index];
    // 1. The parameters of the node's lower, middle and upper planes, then in the order in which the ray meets them.
    const __m128 half = _mm_shuffle_ps(corner, corner, 0xff), middle = _mm_add_ps(corner, half);
    const __m128 t_lower = _mm_mul_ps(_mm_sub_ps(corner, ray.origin_), ray.inverse_);
    const __m128 t_middle = _mm_mul_ps(_mm_sub_ps(middle, ray.origin_), ray.inverse_);
    const __m128 t_upper = _mm_mul_ps(_mm_sub_ps(_mm_add_ps(middle, half), ray.origin_), ray.inverse_);
    const __m256 enter = _mm256_set_m128(t_middle, _mm_blendv_ps(t_lower, t_upper, ray.inverse_));
    const __m256 leave = _mm256_set_m128(_mm_blendv_ps(t_upper, t_lower, ray.inverse_), t_middle);
    // 2. Of all octants.
    const __m256 near = _mm256_max_ps(
        _mm256_max_ps(_mm256_permutevar8x32_ps(enter, ray.select_[0]), _mm256_permutevar8x32_ps(enter, ray.select_[1])),
        _mm256_max_ps(_mm256_permutevar8x32_ps(enter, ray.select_[2]), start));
    const __m256 far = _mm256_min_ps(
        _mm256_min_ps(_mm256_permutevar8x32_ps(leave, ray.select_[0]), _mm256_permutevar8x32_ps(leave, ray.select_[1])),
        _mm256_min_ps(_mm256_permutevar8x32_ps(leave, ray.select_[2]), end));
    const __m256 valid = _mm256_cmp_ps(near, far, _CMP_LT_OQ);
    const int hit = _mm256_movemask_ps(valid);
    visit(index, node, hit, valid, near, far);
    // 3. The nodes among those that are crossed.
    unsigned inner = static_cast<unsigned>(hit) & (kLiveOnly ? node.live : node.inner);
    if (inner != 0) {
      const auto enter_octant = [&](int octant) {
        return Pending{_mm_add_ps(corner, _mm_mul_ps(half, _mm_load_ps(kOffset[octant]))), node.Child(octant)};
      };
      const Pending next = enter_octant(std::countr_zero(inner));
      for (inner &= inner - 1; inner != 0; inner &= inner - 1) stack[waiting++] = enter_octant(std::countr_zero(inner));
      corner = next.corner;
      index = next.node;
      continue;
    }
    if (waiting == 0) return;
    --waiting;
    corner = stack[waiting].corner;
    index = stack[waiting].node;
  }
}

}  // namespace lodestar
