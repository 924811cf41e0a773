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
  FocalRay(Vec3 origin, Vec3 direction) : origin_(_mm_setr_ps(origin.x, origin.y, origin.z, 0)) {
    const __m128 d = _mm_setr_ps(direction.x, direction.y, direction.z, 1), sign = _mm_and_ps(d, _mm_set1_ps(-0.0f));
    const __m128 length = _mm_max_ps(_mm_andnot_ps(sign, _mm_xor_ps(d, sign)), _mm_set1_ps(1e-18f));
    inverse_ = _mm_div_ps(_mm_set1_ps(1), _mm_or_ps(length, sign));
    // In lane c of axis a: a, plus 4 where the octant lies behind the middle plane as the ray goes.
    const __m128i flip = _mm_srli_epi32(_mm_castps_si128(sign), 29);  // 4 where the direction is negative
    select_[0] = _mm256_xor_si256(_mm256_setr_epi32(0, 4, 0, 4, 0, 4, 0, 4), _mm256_broadcastd_epi32(flip));
    select_[1] = _mm256_xor_si256(_mm256_setr_epi32(1, 1, 5, 5, 1, 1, 5, 5),
                                  _mm256_broadcastd_epi32(_mm_shuffle_epi32(flip, 0x55)));
    select_[2] = _mm256_xor_si256(_mm256_setr_epi32(2, 2, 2, 2, 6, 6, 6, 6),
                                  _mm256_broadcastd_epi32(_mm_shuffle_epi32(flip, 0xaa)));
  }

 private:
  friend class FocalOctree;

  __m128 origin_, inverse_;
  __m256i select_[3];
};

class FocalOctree {
 public:
  static constexpr int kMaxDepth = 16;  // a voxel is then 256 steps of a float wide

  struct alignas(64) Node {
    std::array<float, 8> density;  // of leaves: mass / volume, with the cube's volume 1; 0 for nodes
    std::array<float, 3> corner;   // its lower one
    float half;                    // of its size: an octant's
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
    Walk<true>(ray, kInfinity, [&](uint32_t, const Node& node, unsigned, __m256 valid, __m256 t0, __m256 t1) {
      // (t1 - t0)(t1^2 + t1 t0 + t0^2): the difference of cubes cancels for far, thin voxels.
      const __m256 squares = _mm256_add_ps(_mm256_mul_ps(t1, _mm256_add_ps(t1, t0)), _mm256_mul_ps(t0, t0));
      const __m256 cubes = _mm256_mul_ps(_mm256_sub_ps(t1, t0), squares);
      sum = _mm256_add_ps(sum, _mm256_and_ps(valid, _mm256_mul_ps(_mm256_load_ps(node.density.data()), cubes)));
    });
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
  }

  // Calls visit(slot, t0, t1, density) for every leaf voxel that the ray crosses before t_end, t0 < t1, in no order.
  template <class Visit>
  void ForVoxels(const FocalRay& ray, float t_end, Visit&& visit) const {
    Walk<false>(ray, t_end, [&](uint32_t index, const Node& node, unsigned hit, __m256, __m256 near, __m256 far) {
      alignas(32) float t0[8], t1[8];
      _mm256_store_ps(t0, near);
      _mm256_store_ps(t1, far);
      for (unsigned leaves = hit & ~node.inner; leaves != 0; leaves &= leaves - 1) {
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
  size_t memory() const {
    return nodes_.size() * (sizeof(Node) + sizeof(Ends)) + masses_.size() * sizeof(float);
  }

 private:
  template <bool kLiveOnly, class Visit>
  void Walk(const FocalRay& ray, float t_end, Visit&& visit) const;
  // The first four set bits of a byte, a byte each.
  static constexpr std::array<uint32_t, 256> kSetBits = [] {
    std::array<uint32_t, 256> table{};
    for (uint32_t bits = 0; bits < 256; ++bits)
      for (uint32_t bit = 0, count = 0; bit < 8 && count < 4; ++bit)
        if ((bits >> bit) & 1) table[bits] |= bit << (8 * count++);
    return table;
  }();

  // Where each octant's share of the node's mass ends, as masses add up; infinity from the last one of any mass on, so
  // that rounding chooses none without.
  struct alignas(64) Ends {
    double end[8];
  };

  std::vector<Node> nodes_;
  std::vector<float> masses_;  // by slot
  std::vector<Ends> ends_;     // by node
  double mass_ = 0;
  int depth_ = 0;
};

template <bool kLiveOnly, class Visit>
inline void FocalOctree::Walk(const FocalRay& ray, float t_end, Visit&& visit) const {
  // What is still to be walked, first come first served: so most nodes do not have to wait for what the one before
  // finds out, and no branch depends on it. A long ray through a deep octree, that fills the list, goes on with the
  // newest instead, of which there are at most three more a level.
  constexpr uint32_t kFull = 448;
  static_assert(kFull + 3 * kMaxDepth + 8 <= 512);
  uint32_t waiting[512];
  uint32_t first = 0, last = 1;
  waiting[0] = 0;
  const __m256 start = _mm256_setzero_ps(), end = _mm256_set1_ps(t_end);
  while (first != last) {
    const uint32_t index = last > kFull ? waiting[--last] : waiting[first++];
    const Node& node = nodes_[index];
    // 1. The parameters of the node's lower, middle and upper planes, then in the order in which the ray meets them.
    const __m128 corner = _mm_load_ps(node.corner.data()), half = _mm_shuffle_ps(corner, corner, 0xff);
    const __m128 middle = _mm_add_ps(corner, half);
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
    const unsigned hit = static_cast<unsigned>(_mm256_movemask_ps(valid));
    visit(index, node, hit, valid, near, far);
    // 3. The nodes among those that are crossed, of eight at most four: which of the children they are, in a row.
    const unsigned children = _pext_u32(hit & (kLiveOnly ? node.live : node.inner), node.inner);
    const __m128i ranks = _mm_cvtepu8_epi32(_mm_cvtsi32_si128(static_cast<int>(kSetBits[children])));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(&waiting[last]),
                     _mm_add_epi32(ranks, _mm_set1_epi32(static_cast<int>(node.first_child))));
    last += static_cast<uint32_t>(std::popcount(children));
  }
}

}  // namespace lodestar
