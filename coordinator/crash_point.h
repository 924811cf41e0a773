// Named places where tests end the process as kill -9 would: LODESTAR_CRASH_AT=NAME or NAME:N (at the N-th passage).
// Inert without it.
#pragma once

#include <span>

namespace lodestar {

// For tests that visit all of them.
std::span<const char* const> CrashPoints();
void CrashPoint(const char* name);

}  // namespace lodestar
