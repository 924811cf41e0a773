// The power of two that a state multiplies its records by, so that their mean is near 1 in the fixed point of ExactSum
// (docs/decisions/0002-exact-sums.md).
#pragma once

#include "core/base/bytes.h"

namespace lodestar {

// For records of that mean, above zero; within what a float can apply and undo.
float RadianceScaleFor(double mean);
// Fails the reader (Error kCorrupt) for anything but a finite power of two.
float ReadRadianceScale(ByteReader& in);

}  // namespace lodestar
