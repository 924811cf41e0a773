// lodestar-worker: parses, wires and waits.
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <thread>

#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/signals.h"
#include "worker/worker.h"

namespace {

constexpr const char* kFooter = R"(Examples:
  lodestar-worker --coordinator 127.0.0.1:7420
  lodestar-worker --coordinator farm.local:7420 --threads 8 --cache /scratch/lodestar

A worker calls out and needs no open port. It may come and go, or be killed, at any moment of a job; while its coordinator is away it tries again
for ever. SIGTERM and SIGINT drain it: the unit at hand is finished and delivered, others are given back. A second signal ends it at once.

Exit codes: 0 drained, 1 an error (cache folder), 2 wrong usage, 3 the coordinator is of another release.
LODESTAR_LOG=debug|info|warn|error sets how much is logged, to standard error.)";

std::string DefaultCache() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME")) return std::string(folder) + "/lodestar";
  if (const char* home = std::getenv("HOME")) return std::string(home) + "/.cache/lodestar";
  return "/var/tmp/lodestar-" + std::to_string(getuid());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && argv[1] == std::string_view(lodestar::kTrialWord)) return lodestar::RunTrial(argv[2], argv[3]);
  lodestar::Worker::Options options;
  std::string cache = DefaultCache();
  uint64_t cache_mib = options.cache_bytes >> 20, scene_mib = 0;
  CLI::App app("Renders for a Lodestar farm.");
  app.set_version_flag("--version", LODESTAR_VERSION);
  app.footer(kFooter);
  app.add_option("--coordinator", options.coordinator, "HOST:PORT of the coordinator")->required();
  app.add_option("--threads", options.threads,
                 "Threads to render on; 0: as many as this process may use (affinity and cgroup)")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--cache", cache, "Folder for scene files, may be shared by workers of one machine")
      ->capture_default_str();
  app.add_option("--cache-limit", cache_mib, "MiB of scene files to keep there")->capture_default_str();
  app.add_option("--scene-memory", scene_mib,
                 "MiB of memory that compiling a scene may take (one that takes more is given back), and that compiled "
                 "scenes may take together; 0: half of this machine's or cgroup's")
      ->capture_default_str();
  app.add_option("--name", options.name, "Name in lists and logs; default host:pid");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const sigset_t signals = lodestar::BlockTerminationSignals();

  lodestar::InitLog("worker");
  try {
    options.cache = cache;
    options.cache_bytes = cache_mib << 20;
    options.trial.memory_bytes = scene_mib << 20;
    lodestar::Worker worker(options);
    std::thread([&worker, signals] {
      int signal = 0;
      sigwait(&signals, &signal);
      spdlog::info("draining on signal {}", signal);
      worker.Drain();
      sigwait(&signals, &signal);
      _exit(128 + signal);
    }).detach();
    worker.Run();
    return 0;
  } catch (const lodestar::ProtocolError& error) {
    spdlog::error("{}", error.what());
    return 3;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return 1;
  }
}
