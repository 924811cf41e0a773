#include "client/plot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <vector>

extern char** environ;

namespace lodestar {
namespace {

namespace fs = std::filesystem;

constexpr int kNoMatplotlib = 3;  // as the script says it

fs::path Script() {
  if (const char* script = std::getenv("LODESTAR_PLOT")) return script;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path().parent_path() / "share/lodestar/lodestar_plot.py";
  return fs::exists(installed, error) ? installed : fs::path(LODESTAR_PLOT_SCRIPT);
}

std::vector<fs::path> Interpreters() {
  std::vector<fs::path> found;
  if (const char* python = std::getenv("LODESTAR_PYTHON")) found.emplace_back(python);
  found.emplace_back("/usr/bin/python3");
  if (const char* path = std::getenv("PATH")) {
    std::stringstream folders(path);
    for (std::string folder; std::getline(folders, folder, ':');) {
      fs::path candidate = fs::path(folder.empty() ? "." : folder) / "python3";
      if (candidate != found.back() && access(candidate.c_str(), X_OK) == 0) found.push_back(std::move(candidate));
    }
  }
  return found;
}

// The exit code, -1 where the program could not be started or was killed.
int Run(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // Standard out belongs to --json.
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  pid_t pid = 0;
  const int failed = posix_spawn(&pid, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return -1;
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

bool DrawErrorPlot(const fs::path& csv, const fs::path& png, const std::string& title) {
  const fs::path script = Script();
  std::error_code error;
  if (!fs::exists(script, error)) {
    std::fprintf(stderr, "no plot: %s is missing; set LODESTAR_PLOT to client/python/lodestar_plot.py\n",
                 script.c_str());
    return false;
  }
  for (const fs::path& python : Interpreters()) {
    const int code = Run({python.string(), script.string(), csv.string(), "-o", png.string(), "--title", title});
    if (code == 0) return true;
    if (code == kNoMatplotlib || code == -1 || code == 127) continue;
    std::fprintf(stderr, "no plot: %s ended with code %d on %s\n", script.c_str(), code, csv.c_str());
    return false;
  }
  std::fprintf(stderr,
               "no plot: no python3 here has matplotlib; try: apt-get install python3-matplotlib, then %s %s -o %s\n",
               script.c_str(), csv.c_str(), png.c_str());
  return false;
}

}  // namespace lodestar
