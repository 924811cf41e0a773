// CHECK ends the process on a broken invariant (a bug of ours, never bad input); DCHECK does so in dev and sanitizer
// builds only.
#pragma once

namespace lodestar {

[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);

}  // namespace lodestar

#define LODESTAR_CHECK(condition) \
  (static_cast<bool>(condition) ? (void)0 : ::lodestar::CheckFailed(#condition, __FILE__, __LINE__))
#ifdef LODESTAR_DCHECKS
#define LODESTAR_DCHECK(condition) LODESTAR_CHECK(condition)
#else
#define LODESTAR_DCHECK(condition) ((void)0)
#endif
