#include "core/guiding/nee_probability.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lodestar {
namespace {

// Cost of a light sample in units of a path vertex: its shadow ray is shorter than a path ray and nothing is shaded at
// its end.
constexpr double kLightSampleCost = 0.5;

}  // namespace

void NeeSums::Add(float direct_light, float reflected_light, uint32_t path_vertices) {
  const auto usable = [](float value) { return value >= 0 && value <= std::numeric_limits<float>::max(); };
  if (!usable(direct_light) || !usable(reflected_light)) return;
  const auto bounded = [](float value) { return std::min(value, std::numeric_limits<float>::max()); };
  direct.Add(direct_light);
  direct_squared.Add(bounded(direct_light * direct_light));
  reflected.Add(reflected_light);
  reflected_squared.Add(bounded(reflected_light * reflected_light));
  vertices += path_vertices;
  ++count;
}

void NeeSums::Merge(const NeeSums& other) {
  direct.Merge(other.direct);
  direct_squared.Merge(other.direct_squared);
  reflected.Merge(other.reflected);
  reflected_squared.Merge(other.reflected_squared);
  vertices += other.vertices;
  count += other.count;
}

float SolveNeeProbability(const NeeSums& sums, float previous, double min_records) {
  const double n = static_cast<double>(sums.count);
  if (n < min_records) return previous;
  // At a share q a light sample counts 1/q: its second moment is that at q = 1, over q.
  const double nee = sums.direct_squared.Value() / n * previous;
  const double mean_nee = sums.direct.Value() / n, mean_rest = sums.reflected.Value() / n;
  const double rest = sums.reflected_squared.Value() / n - mean_rest * mean_rest - mean_nee * mean_nee;
  if (!(rest > 0)) return nee > 0 ? 1.0f : previous;
  const double cost_rest = static_cast<double>(sums.vertices) / n;
  const double share = std::sqrt(nee * cost_rest / (rest * kLightSampleCost));
  return static_cast<float>(std::clamp(share, static_cast<double>(kLeastNeeProbability), 1.0));
}

}  // namespace lodestar
