// Counters of samples that a gate refused or changed, and the first offending pixel sample, so that it can be replayed.
// Merging is order-free: counts add, and the offender with the smallest (pass, pixel) wins.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/base/bytes.h"

namespace lodestar {

enum class HealthEvent : uint8_t {
  kNan,  // of pixel samples
  kInfinite,
  kNegative,
  kZeroPdf,
  kClamped,
  kSaturated,  // of what is learned from: a sum at the end of its range,
  kRefused,    // a record that is not finite, negative, or of no density
};
inline constexpr int kHealthEvents = 7;
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
  // Events of no pixel sample that is known.
  void Add(HealthEvent event, uint64_t count) { counts[static_cast<size_t>(event)] += count; }
  void Merge(const HealthReport& other);
  uint64_t total() const;
  void Write(ByteWriter& out) const;
  static HealthReport Read(ByteReader& in);
};

}  // namespace lodestar
