#include "worker/compile_trial.h"

#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <new>
#include <thread>

#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/tracer.h"

namespace lodestar {
namespace {

namespace fs = std::filesystem;

// Exit codes of the child; anything else is a death.
enum Outcome : int { kCompiled = 0, kSceneError = 10, kOutOfMemory = 11 };

// Beside the scene's folder, which holds the scene's files alone: what the child is to do; and what came of it, the
// memory it took or the error it met.
fs::path JobFile(const fs::path& folder) {
  return folder.string() + ".job";
}
fs::path ResultFile(const fs::path& folder) {
  return folder.string() + ".result";
}

struct FileRemover {
  fs::path path;
  ~FileRemover() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
};

void WriteFile(const fs::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw Error(ErrorKind::kIo, path.string() + " cannot be written: is its disk full?");
}
Bytes ReadFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

pid_t Start(const fs::path& program, const fs::path& folder, uint64_t memory_mib) {
  std::string words[] = {program.string(), kTrialWord, folder.string(), std::to_string(memory_mib)};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  // A worker waits for its termination signals in one thread and blocks them in all. Ctrl-C in its terminal, which goes
  // to the whole group, is the worker's alone: it drains, and the scene must not look as if it had killed its process.
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  pid_t pid = -1;
  const int failed = posix_spawn(&pid, arguments[0], nullptr, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  if (failed) throw Error(ErrorKind::kIo, program.string() + " cannot be started: " + strerror(failed));
  return pid;
}

// At most, so far, of this process. (What a parent can ask, ru_maxrss, begins with the parent's own.)
uint64_t PeakBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    uint64_t kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib << 10;
  }
  return 0;
}

// Its exit status; a stop request ends it.
int Wait(pid_t pid, const StopToken& stop) {
  for (int status = 0;; std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
    if (waitpid(pid, &status, WNOHANG) == pid) return status;
    if (!stop.Requested()) continue;
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
    throw Error(ErrorKind::kIo, "given up");
  }
}

}  // namespace

CompileTrial::CompileTrial(const Options& options) : options_(options) {
  if (options_.memory_bytes == 0) options_.memory_bytes = UsableMemory() / 2;
}

uint64_t CompileTrial::Run(const JobDescription& description, const fs::path& folder, const StopToken& stop) const {
  const FileRemover job{JobFile(folder)}, result{ResultFile(folder)};
  WriteFile(job.path, description.Serialize());
  const uint64_t mib = options_.memory_bytes >> 20;
  const int status = Wait(Start(options_.program, folder, mib), stop);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  const Bytes said = ReadFile(result.path);
  if (code == kCompiled) return std::strtoull(said.c_str(), nullptr, 10);
  const std::string& scene = description.scene.main;
  if (code == kSceneError) {
    const ErrorKind kind = said.empty() ? ErrorKind::kIo : static_cast<ErrorKind>(said[0]);
    // What is not the scene's fault does not name it.
    throw Error(kind, (kind == ErrorKind::kIo ? "compiling " + scene + ": " : "") + said.substr(said.empty() ? 0 : 1));
  }
  const std::string limit = "the " + std::to_string(mib) + " MiB of memory that this worker gives a scene";
  if (code == kOutOfMemory) {
    throw Error(ErrorKind::kIo, "compiling " + scene + " takes more than " + limit +
                                    "; render it where there is more, or raise lodestar-worker --scene-memory");
  }
  const std::string death =
      WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")"
                          : "code " + std::to_string(code);
  throw Error(ErrorKind::kIo, "compiling " + scene + " ended its process with " + death + ", within " + limit +
                                  "; 'lodestar inspect' shows whether it does so elsewhere too");
}

int RunTrial(const std::string& folder, const std::string& memory_mib) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Should the machine itself run out of memory, this process goes first.
  std::ofstream("/proc/self/oom_score_adj") << 1000;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // What it writes to, and not its address space: libraries and files that are mapped take none.
  const rlim_t bytes = std::strtoull(memory_mib.c_str(), nullptr, 10) << 20;
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_DATA, &limit);
#endif
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const auto failed = [&](ErrorKind kind, const char* what) {
    WriteFile(ResultFile(folder), std::string(1, static_cast<char>(kind)) + what);
    return kSceneError;
  };
  try {
    const auto description = JobDescription::Parse(ReadFile(JobFile(folder)));
    const auto scene = ParsePbrtFile(fs::path(folder) / description.scene.main,
                                     {.lenient = description.spec.lenient, .within = folder});
    (void)CompileJob(scene, description.spec);
    WriteFile(ResultFile(folder), std::to_string(PeakBytes()));
    return kCompiled;
  } catch (const Error& error) {
    return failed(error.kind(), error.what());
  } catch (const std::bad_alloc&) {
    return kOutOfMemory;
  } catch (const std::exception& error) {
    return failed(ErrorKind::kIo, error.what());
  }
}

}  // namespace lodestar
