// Metropolis sampling of a table (Kim 2022, algorithm 5) by a chain whose distribution is known.
//
// The document keeps one chain per place in memory that all threads change: its samples depend on who came before, are
// not distributed as the table says, and race. In a farm of pure units there is no such memory. Here every sample has a
// chain of its own: kChainSteps moves from an even start, drawn from the sample's random numbers. Such a chain has not
// reached the table's distribution, but the one it has reached is computed exactly, and that is the density.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/hash.h"
#include "core/math/vec.h"

namespace lodestar {

// Random numbers without end from those of one sample.
class GridRandom {
 public:
  GridRandom(Vec2 u, float u_more)
      : key_(Mix64((static_cast<uint64_t>(u.x * 0x1p24f) << 40) ^ (static_cast<uint64_t>(u.y * 0x1p24f) << 16) ^
                   static_cast<uint64_t>(u_more * 0x1p24f))) {}
  Vec2 Next2D() {
    const uint64_t bits = Mix64(key_ += 0x9e3779b97f4a7c15ULL);
    return {ToUnit(static_cast<uint32_t>(bits >> 32)), ToUnit(static_cast<uint32_t>(bits))};
  }

 private:
  static float ToUnit(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }
  uint64_t key_;
};

inline constexpr int kChainSteps = 16;
inline constexpr float kFarMove = 0.1f;  // chance to propose any cell; else one of the four beside (the document's 0.9)

// The cell at the chain's end. `target`: of rows by columns cells, unnormalised; columns wrap around.
uint32_t RunChain(std::span<const float> target, uint32_t rows, uint32_t columns, GridRandom& random);
// The probability of each cell to be that end.
std::vector<double> ChainDistribution(std::span<const float> target, uint32_t rows, uint32_t columns);

}  // namespace lodestar
