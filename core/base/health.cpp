#include "core/base/health.h"

#include <tuple>

namespace lodestar {

const char* HealthEventName(HealthEvent event) {
  static constexpr const char* kNames[kHealthEvents] = {"nan",     "infinite",  "negative", "zero_pdf",
                                                        "clamped", "saturated", "refused"};
  return kNames[static_cast<int>(event)];
}

void HealthReport::Count(HealthEvent event, uint32_t x, uint32_t y, uint32_t pass, uint32_t iteration) {
  ++counts[static_cast<int>(event)];
  const Offender offender{x, y, pass, event, iteration};
  if (std::tie(offender.pass, offender.pixel_y, offender.pixel_x) < std::tie(first.pass, first.pixel_y, first.pixel_x))
    first = offender;
}

void HealthReport::Merge(const HealthReport& other) {
  for (int i = 0; i < kHealthEvents; ++i) counts[i] += other.counts[i];
  if (std::tie(other.first.pass, other.first.pixel_y, other.first.pixel_x) <
      std::tie(first.pass, first.pixel_y, first.pixel_x))
    first = other.first;
}

uint64_t HealthReport::total() const {
  uint64_t sum = 0;
  for (const uint64_t count : counts) sum += count;
  return sum;
}

void HealthReport::Write(ByteWriter& out) const {
  for (const uint64_t count : counts) out.Put(count);
  out.Put(first.pixel_x);
  out.Put(first.pixel_y);
  out.Put(first.pass);
  out.Put(first.event);
  out.Put(first.iteration);
}

HealthReport HealthReport::Read(ByteReader& in) {
  HealthReport report;
  for (uint64_t& count : report.counts) count = in.Get<uint64_t>();
  report.first.pixel_x = in.Get<uint32_t>();
  report.first.pixel_y = in.Get<uint32_t>();
  report.first.pass = in.Get<uint32_t>();
  report.first.event = in.Get<HealthEvent>();
  report.first.iteration = in.Get<uint32_t>();
  if (static_cast<int>(report.first.event) >= kHealthEvents) in.Fail("names an unknown health event");
  return report;
}

}  // namespace lodestar
