// Signals that ask a server to end, taken by one thread with sigwait.
#pragma once

#include <csignal>

namespace lodestar {

// Blocks SIGTERM and SIGINT in this thread and in every one it starts from now on: call it before any is started.
// Returns them, for sigwait.
inline sigset_t BlockTerminationSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

}  // namespace lodestar
