// Processes of a test: started with their output in a file, and ended with the object whatever happens.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace lodestar {

class Process {
 public:
  Process() = default;
  // `environment`: "NAME=VALUE" beside this process's own. Standard output and error go to `log`, appended.
  Process(const std::vector<std::string>& command, const std::filesystem::path& log,
          const std::vector<std::string>& environment = {});
  ~Process();
  Process(Process&& other) noexcept { *this = std::move(other); }
  Process& operator=(Process&& other) noexcept;

  bool running();  // reaps
  void Signal(int signal);
  void Kill() { Signal(9), (void)Wait(std::chrono::seconds(10)); }
  // Exit code; 128 + N for signal N; -1: still running after the time.
  int Wait(std::chrono::milliseconds limit);
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int code_ = -1;
};

// True once `condition` holds; polls, for at most `limit`.
template <class Condition>
bool Eventually(std::chrono::milliseconds limit, Condition&& condition);

}  // namespace lodestar

#include <thread>

namespace lodestar {
template <class Condition>
bool Eventually(std::chrono::milliseconds limit, Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}
}  // namespace lodestar
