#include "core/math/exact_sum.h"

namespace lodestar {

ExactSum ExactSum::FromUnits(Wide units) {
  // Clamped before it is added: a value near the ends of the 128 bits would wrap in the addition.
  if (units > kMax) units = kMax;
  if (units < -kMax) units = -kMax;
  ExactSum sum;
  sum.AddUnits(units);
  return sum;
}

}  // namespace lodestar
