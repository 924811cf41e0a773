// A sum of floats that does not depend on the order or grouping of its addends: 128-bit fixed point
// (docs/decisions/0002-exact-sums.md).
//
// One unit is 2^-56 and the range ends at +-2^70. Each float is converted once (exactly, unless it has bits below the
// unit: those are rounded, halves away from zero) and from then on everything is integer addition. Sums saturate at the
// limit. Saturation keeps the order freedom for addends of one sign; with both signs it holds as long as no partial sum
// can reach the limit.
#pragma once

#include <bit>
#include <cstdint>

#include "core/base/check.h"

namespace lodestar {

class ExactSum {
 public:
  static constexpr int kFractionBits = 56;
  static constexpr double kLimit = 0x1p70;
  using Wide = __int128;

  // Adds a finite value. False when the value alone lies beyond the limit (it is clamped; the caller counts).
  bool Add(float value) {
    const uint32_t bits = std::bit_cast<uint32_t>(value);
    const int exponent = static_cast<int>((bits >> 23) & 0xff);
    const uint64_t mantissa = (bits & 0x7fffff) | 0x800000;
    LODESTAR_DCHECK(exponent != 0xff);
    unsigned __int128 magnitude;
    bool fits = true;
    if (exponent >= kUnitExponent) [[likely]] {
      fits = exponent < kLimitExponent;
      magnitude = fits ? static_cast<unsigned __int128>(mantissa) << (exponent - kUnitExponent)
                       : static_cast<unsigned __int128>(kMax);
    } else {
      const int drop = kUnitExponent - exponent;
      if (drop > 24) return true;  // below half a unit, denormals and zero included
      magnitude = (mantissa + (uint64_t{1} << (drop - 1))) >> drop;
    }
    AddUnits((bits >> 31) ? -static_cast<Wide>(magnitude) : static_cast<Wide>(magnitude));
    return fits;
  }

  void Merge(const ExactSum& other) {
    // As AddUnits, with one comparison for both limits: merging whole accumulators is bound by this loop.
    uint64_t lo;
    const bool carry = __builtin_add_overflow(lo_, other.lo_, &lo);
    const uint64_t hi = static_cast<uint64_t>(hi_) + static_cast<uint64_t>(other.hi_) + carry;
    constexpr uint64_t kInside = (uint64_t{1} << 62) - 1;
    if (hi + kInside > 2 * kInside) [[unlikely]]
      return AddUnits(other.Units());
    lo_ = lo;
    hi_ = static_cast<int64_t>(hi);
  }

  // The nearest double.
  double Value() const { return static_cast<double>(Units()) * 0x1p-56; }
  bool zero() const { return (lo_ | static_cast<uint64_t>(hi_)) == 0; }
  bool saturated() const { return Units() >= kMax || Units() <= -kMax; }

  Wide Units() const {
    return static_cast<Wide>((static_cast<unsigned __int128>(static_cast<uint64_t>(hi_)) << 64) | lo_);
  }
  // |units| <= 2^126 - 1, else clamped.
  static ExactSum FromUnits(Wide units) {
    // Clamped before it is added: a value near the ends of the 128 bits would wrap in the addition.
    if (units > kMax) units = kMax;
    if (units < -kMax) units = -kMax;
    ExactSum sum;
    sum.AddUnits(units);
    return sum;
  }

  friend bool operator==(const ExactSum&, const ExactSum&) = default;

 private:
  static constexpr int kUnitExponent =
      127 + 23 - kFractionBits;  // biased exponent at which the mantissa's last bit is one unit
  static constexpr int kLimitExponent = 127 + 70;
  static constexpr Wide kMax = (static_cast<Wide>(1) << 126) - 1;

  // Neither operand exceeds 2^126 - 1, so the sum of two fits in 127 bits and can be clamped afterwards.
  void AddUnits(Wide units) {
    Wide sum = Units() + units;
    if (sum > kMax) [[unlikely]]
      sum = kMax;
    if (sum < -kMax) [[unlikely]]
      sum = -kMax;
    lo_ = static_cast<uint64_t>(sum);
    hi_ = static_cast<int64_t>(sum >> 64);
  }

  uint64_t lo_ = 0;
  int64_t hi_ = 0;
};

}  // namespace lodestar
