// Russian roulette as an option of methods.
#pragma once

#include <cstdint>

namespace lodestar {

// What a path's survival depends on: its throughput; what a guide expects it to contribute, against what its first
// guided vertex expects (docs/decisions/0006-roulette.md); the same against the estimate of its pixel (Vorba and
// Krivanek 2016, adjoint-driven).
enum class Roulette : uint8_t { kThroughput, kContribution, kPixel };

}  // namespace lodestar
