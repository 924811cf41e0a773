#include "client/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>

#include "client/exit_code.h"
#include "core/base/check.h"

namespace lodestar {
namespace {

std::atomic<StopToken*> g_stop{nullptr};
std::atomic<bool> g_interrupted{false};
std::atomic<const char*> g_says{nullptr};
static_assert(std::atomic<StopToken*>::is_always_lock_free && std::atomic<bool>::is_always_lock_free &&
              std::atomic<const char*>::is_always_lock_free);

// Only async-signal-safe calls.
void OnSignal(int number) {
  const bool again = g_interrupted.exchange(true);
  if (number == SIGHUP) {
    // A connection that drops hangs up twice, by the shell and by the kernel: that is no wish to quit at once.
    std::signal(SIGHUP, SIG_IGN);
    if (again) return;
  }
  if (again) _exit(static_cast<int>(ExitCode::kInterrupted));
  for (const char* part : {"\n", g_says.load(), " (Ctrl-C again quits at once)\n"})
    [[maybe_unused]] const auto written = write(STDERR_FILENO, part, std::strlen(part));
  if (StopToken* stop = g_stop.load()) stop->Request();
}

// By nohup, or by OnSignal.
bool HangupIgnored() {
  struct sigaction action = {};
  sigaction(SIGHUP, nullptr, &action);
  return action.sa_handler == SIG_IGN;
}

}  // namespace

InterruptGuard::InterruptGuard(StopToken* stop, const char* says) {
  StopToken* expected = nullptr;
  LODESTAR_CHECK(g_stop.compare_exchange_strong(expected, stop));
  g_says.store(says);
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  if (!HangupIgnored()) sigaction(SIGHUP, &action, nullptr);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (!HangupIgnored()) std::signal(SIGHUP, SIG_DFL);
  g_stop.store(nullptr);
}

bool InterruptGuard::Interrupted() {
  return g_interrupted.load();
}

}  // namespace lodestar
