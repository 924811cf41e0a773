#include "core/guiding/grid_advance.h"

#include <cmath>

#include "core/base/check.h"
#include "core/guiding/radiance_scale.h"

namespace lodestar {
namespace {

// base^n by squaring: no libm in what is merged.
double Power(double base, uint64_t n) {
  double result = 1;
  for (; n > 0; n >>= 1, base *= base)
    if (n & 1) result *= base;
  return result;
}

}  // namespace

std::shared_ptr<const RadianceGrid> Advance(const RadianceGrid& grid, const GridStatistics& statistics) {
  LODESTAR_CHECK(grid.fingerprint() == statistics.grid()->fingerprint());
  GridParts parts = grid.parts();
  ++parts.iteration;
  const double unscale = 1.0 / grid.radiance_scale(), left = 1.0 - double{parts.options.learning_rate};
  double total = 0, records = 0;
  statistics.ForEach([&](size_t entry, const GridStatistics::Sum& sum) {
    const double value = sum.value.Value() * unscale, count = static_cast<double>(sum.count);
    total += value;
    records += count;
    const double kept = Power(left, sum.count), before = kept * parts.weight[entry], now = 1 - kept;
    const double radiance = (before * parts.radiance[entry] + now * (value / count)) / (before + now);
    parts.radiance[entry] = static_cast<float>(std::min(radiance, 3e38));
    parts.weight[entry] = static_cast<float>(before + now);
  });
  if (total > 0) parts.radiance_scale = RadianceScaleFor(total / records);
  return std::make_shared<const RadianceGrid>(std::move(parts));
}

}  // namespace lodestar
