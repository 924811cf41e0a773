// Ctrl-C: the first asks the work to stop and lets the command write what it has, the second ends the process at once.
// A terminal that hangs up (SIGHUP) only asks, however often.
#pragma once

#include "core/base/stop.h"

namespace lodestar {

// While an object lives, SIGINT, SIGTERM and, unless it is ignored (nohup), SIGHUP request `stop`. One at a time a
// process; it should live until all is written.
class InterruptGuard {
 public:
  // `says`, a literal, tells the user what comes now.
  InterruptGuard(StopToken* stop, const char* says);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  // A signal came.
  static bool Interrupted();
};

}  // namespace lodestar
