// Random numbers of one pixel sample: a pure function of (job seed, pixel, iteration, pass, dimension), never of
// thread, worker, time or order.
//
// The first kSobolPairs pairs of dimensions are the first two Sobol' dimensions, Owen-scrambled and shuffled by hashing
// (Burley 2020, "Practical Hash-based Owen Scrambling"), stratified over blocks of kBlockPasses passes; each block is
// scrambled on its own, so blocks are independent and a variance from per-sample moments is at worst too large. So is
// each iteration: what a guide has learned from the first passes of a block must not know the others' numbers. Later
// dimensions gain nothing from stratification at the counts that are affordable there and are plain hashes, which cost
// a quarter.
#pragma once

#include <bit>
#include <cstdint>

#include "core/base/hash.h"
#include "core/math/vec.h"

namespace lodestar {

class Sampler {
 public:
  static constexpr uint32_t kBlockPasses = 16;
  static constexpr uint32_t kSobolPairs = 6;

  // Passes count through all iterations.
  Sampler(uint64_t seed, uint32_t pixel_x, uint32_t pixel_y, uint32_t pass, uint32_t iteration = 0)
      : block_key_(MixCombine(seed, (uint64_t{pixel_y} << 32) | pixel_x) +
                   (uint64_t{iteration} << 32 | pass / kBlockPasses) * 0xd1342543de82ef95ULL),
        pass_key_(Mix64(block_key_ + (pass % kBlockPasses) * 0x9e3779b97f4a7c15ULL)),
        reversed_index_(ReverseBits(pass % kBlockPasses)) {}

  // The next dimension pairs are those from `pair` on. A path gives each vertex a fixed range, so that a vertex which
  // needs fewer numbers does not shift those of the next.
  void StartAt(uint32_t pair) { pair_ = pair; }

  Vec2 Next2D() {
    const uint32_t pair = pair_++;
    if (pair < kSobolPairs) return Sobol(pair);
    const uint64_t bits = Mix64(pass_key_ + (pair + 1) * 0x9e3779b97f4a7c15ULL);
    return {ToUnit(static_cast<uint32_t>(bits >> 32)), ToUnit(static_cast<uint32_t>(bits))};
  }
  // `u`, one of this sample's numbers, with 24 more bits from a hash of it: for a choice among many, where the steps of
  // u would be felt. A multiple of 2^-48.
  double Refine(float u) const {
    const uint64_t bits = Mix64(pass_key_ + std::bit_cast<uint32_t>(u) * 0xe7037ed1a0b428dbULL);
    return double{u} + static_cast<double>(bits >> 40) * 0x1p-48;
  }
  // Names this pixel sample; for hashes that need more numbers than the path itself.
  uint64_t key() const { return pass_key_; }

  // [0, 1) with 24 bits.
  static float ToUnit(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

 private:
  static uint64_t ReverseBits(uint64_t v) {
    v = __builtin_bswap64(v);
    v = ((v >> 4) & 0x0f0f0f0f0f0f0f0fu) | ((v & 0x0f0f0f0f0f0f0f0fu) << 4);
    v = ((v >> 2) & 0x3333333333333333u) | ((v & 0x3333333333333333u) << 2);
    return ((v >> 1) & 0x5555555555555555u) | ((v & 0x5555555555555555u) << 1);
  }
  static uint32_t ReverseBits(uint32_t v) { return static_cast<uint32_t>(ReverseBits(uint64_t{v}) >> 32); }
  // A base-2 nested uniform scramble of a bit-reversed value (Laine and Karras 2011, constants by Vegdahl 2021).
  static uint32_t ScrambleReversed(uint32_t v, uint32_t seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
  }
  // Second Sobol' dimension of a 32-bit index (its generator matrix is Pascal's triangle modulo 2), already
  // bit-reversed.
  static uint32_t SecondDimensionReversed(uint32_t i) {
    i ^= i >> 16;
    i ^= (i & 0xff00ff00u) >> 8;
    i ^= (i & 0xf0f0f0f0u) >> 4;
    i ^= (i & 0xccccccccu) >> 2;
    i ^= (i & 0xaaaaaaaau) >> 1;
    return i;
  }
  Vec2 Sobol(uint32_t pair) const {
    const uint64_t key = Mix64(block_key_ + (pair + 1) * 0xa0761d6478bd642fULL);
    const uint32_t shuffled = ReverseBits(ScrambleReversed(reversed_index_, static_cast<uint32_t>(key)));
    const uint64_t scramble = Mix64(key);
    const uint32_t x = ScrambleReversed(shuffled, static_cast<uint32_t>(scramble));
    const uint32_t y = ScrambleReversed(SecondDimensionReversed(shuffled), static_cast<uint32_t>(scramble >> 32));
    const uint64_t xy = ReverseBits(uint64_t{x} | uint64_t{y} << 32);
    return {ToUnit(static_cast<uint32_t>(xy >> 32)), ToUnit(static_cast<uint32_t>(xy))};
  }

  uint64_t block_key_, pass_key_;
  uint32_t reversed_index_;  // of the pass in its block
  uint32_t pair_ = 0;
};

}  // namespace lodestar
