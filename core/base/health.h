// Counters of samples that a gate refused or changed, and the first offending pixel sample, so that it can be replayed.
// Merging is order-free: counts add, and the offender with the smallest (pass, pixel) wins.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/base/bytes.h"

namespace lodestar {

enum class HealthEvent : uint8_t { kNan, kInfinite, kNegative, kZeroPdf, kClamped, kSaturated };
inline constexpr int kHealthEvents = 6;
const char* HealthEventName(HealthEvent event);

struct HealthReport {
  struct Offender {
    uint32_t pixel_x = 0, pixel_y = 0;
    uint32_t pass = ~0u;  // ~0: none
    HealthEvent event = HealthEvent::kNan;
    uint32_t iteration = 0;  // the state that was in use
    bool exists() const { return pass != ~0u; }
  };
  std::array<uint64_t, kHealthEvents> counts{};
  Offender first;

  void Count(HealthEvent event, uint32_t x, uint32_t y, uint32_t pass, uint32_t iteration);
  void Merge(const HealthReport& other);
  uint64_t total() const;
  void Write(ByteWriter& out) const;
  static HealthReport Read(ByteReader& in);
};

}  // namespace lodestar
