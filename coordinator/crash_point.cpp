#include "coordinator/crash_point.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/base/check.h"

namespace lodestar {
namespace {

constexpr const char* kNames[] = {
    "blob-written",       // the temporary file is complete and synchronised
    "blob-renamed",       // it has its name, the row is missing
    "blob-committed",     // the row is there
    "job-before-commit",  // a submitted job, inside its transaction
    "job-committed",        "survey-committed",
    "contribution-merged",  // in memory only
    "checkpoint-begin",     // before its blob
    "checkpoint-blob",      // its blob is there, the row still names the old one
    "checkpoint-committed",
    "result-blob",  // the final image is stored, the job not yet done
    "done-committed",
};

struct Target {
  std::string name;
  std::atomic<int> left{1};
  Target() {
    const char* text = std::getenv("LODESTAR_CRASH_AT");
    if (!text) return;
    name = text;
    if (const auto colon = name.find(':'); colon != std::string::npos) {
      left = std::max(1, std::atoi(name.c_str() + colon + 1));
      name.resize(colon);
    }
  }
};

}  // namespace

std::span<const char* const> CrashPoints() {
  return kNames;
}

void CrashPoint(const char* name) {
  static Target target;
  LODESTAR_DCHECK(
      std::any_of(std::begin(kNames), std::end(kNames), [&](const char* n) { return std::string_view(n) == name; }));
  if (target.name.empty() || target.name != name) return;
  if (--target.left == 0) kill(getpid(), SIGKILL);
}

}  // namespace lodestar
