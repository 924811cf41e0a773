#include "core/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace lodestar {

void CheckFailed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: internal error, please report it: check failed: %s\n", file, line, condition);
  std::fflush(stderr);
  std::abort();
}

}  // namespace lodestar
