// lodestar-coordinator: parses, wires and waits.
#include <signal.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "coordinator/service/server.h"
#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/signals.h"
#include "core/base/threads.h"

namespace {

constexpr const char* kFooter = R"(Examples:
  lodestar-coordinator --store /var/lib/lodestar                      # 127.0.0.1:7420
  lodestar-coordinator --store farm --listen 127.0.0.1:0 --port-file farm.port
  lodestar-coordinator --store farm --listen 0.0.0.0:7420 --insecure  # on a network that you trust

It runs until SIGTERM or SIGINT, then stores the position of its jobs; killed in any other way it resumes from the last checkpoint, and the
images are the same to the bit.

Exit codes: 0 ended by a signal, 1 an error (port taken, store unreadable or held by another, disk), 2 wrong usage, 4 another coordinator has taken over the store.
LODESTAR_LOG=debug|info|warn|error sets how much is logged, to standard error.)";

void WritePortFile(const std::string& file, int port) {
  // Renamed into place: whoever sees the file sees the whole of it.
  const std::string temporary = file + ".tmp";
  std::ofstream(temporary) << port << "\n";
  std::filesystem::rename(temporary, file);
}

}  // namespace

int main(int argc, char** argv) {
  lodestar::Server::Options server_options;
  lodestar::Farm::Options farm_options;
  std::string store, port_file;
  uint64_t reserve_mib = 256;
  double checkpoint_seconds = 30, lease_seconds = 10;

  CLI::App app("Coordinates a Lodestar render farm: takes jobs, hands out work, merges results.");
  app.set_version_flag("--version", LODESTAR_VERSION);
  app.footer(kFooter);
  server_options.listen = "127.0.0.1:7420";
  app.add_option("--listen", server_options.listen, "HOST:PORT to listen on; port 0 takes a free one")
      ->capture_default_str();
  app.add_option("--store", store, "Folder of the job store; made where it is missing. One coordinator a folder")
      ->required();
  app.add_flag("--insecure", server_options.insecure,
               "Allow to listen where other machines can reach it (nothing is encrypted or authenticated yet)");
  app.add_option("--port-file", port_file, "Write the chosen port to this file once ready");
  app.add_option("--max-running", farm_options.max_running,
                 "Jobs whose rounds are handed out at a time; the others queue")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--max-queued", farm_options.max_queued, "Jobs that have not ended; beyond it submitting is refused")
      ->capture_default_str();
  app.add_option("--checkpoint", checkpoint_seconds, "Seconds between checkpoints of a running job")
      ->check(CLI::Range(0.001, 86400.0))
      ->capture_default_str();
  app.add_option("--lease", lease_seconds, "Seconds after which a worker that is not heard of loses its leases")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  app.add_option("--reserve", reserve_mib, "MiB of the store's disk that uploads leave free, for the results of jobs")
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  const sigset_t signals = lodestar::BlockTerminationSignals();

  lodestar::InitLog("coordinator");
  try {
    farm_options.store = store;
    farm_options.blobs.reserve_bytes = reserve_mib << 20;
    farm_options.checkpoint_interval = std::chrono::milliseconds(static_cast<int64_t>(checkpoint_seconds * 1000));
    farm_options.checkpoint_least =
        std::min<lodestar::Clock::Duration>(farm_options.checkpoint_least, farm_options.checkpoint_interval);
    farm_options.leases.duration = std::chrono::milliseconds(static_cast<int64_t>(lease_seconds * 1000));
    farm_options.fatal = [](const std::string& why) {
      spdlog::critical("{}", why);
      _exit(4);
    };
    // TBB knows the machine's cores, not what a control group leaves of them.
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(lodestar::UsableThreads()));
    lodestar::Server::CheckAddress(server_options);  // before the store is opened
    lodestar::Farm farm(farm_options);
    lodestar::Server server(farm, server_options);
    spdlog::info("ready on {}, store {}, epoch {}", server.address(), store, farm.epoch());
    std::cout << server.address() << std::endl;
    if (!port_file.empty()) WritePortFile(port_file, server.port());
    int signal = 0;
    sigwait(&signals, &signal);
    spdlog::info("ending on signal {}", signal);
    return 0;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return 1;
  }
}
