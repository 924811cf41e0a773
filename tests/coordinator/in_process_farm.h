// A coordinator within the test's process, reached over real gRPC.
#pragma once

#include <gtest/gtest.h>

#include "coordinator/service/server.h"
#include "rpc/farm_client.h"
#include "rpc/work_client.h"
#include "tests/farm/support/farm_fixture.h"
#include "tests/support/temporary_folder.h"
#include "worker/worker.h"

namespace lodestar {

struct InProcessFarm : testing::Test {
  ManualClock clock;  // of a farm whose time the test moves
  TemporaryFolder folder;
  SceneBundle box = WriteBox(folder.path() / "scene");
  std::unique_ptr<Farm> farm;
  std::unique_ptr<Server> server;
  std::unique_ptr<FarmClient> client;
  Farm::Options options;

  explicit InProcessFarm(bool manual_time = false) {
    if (manual_time) options.clock = &clock;
    options.store = folder.path() / "store";
    options.leases.duration = std::chrono::seconds(2);
    options.leases.straggler_grace = std::chrono::milliseconds(50);
    options.leases.unknown_grace = std::chrono::milliseconds(300);
    options.blobs.reserve_bytes = 1 << 20;
    Start();
  }
  ~InProcessFarm() override { End(); }
  void Start() {
    farm = std::make_unique<Farm>(options);
    server = std::make_unique<Server>(*farm, Server::Options());
    client = std::make_unique<FarmClient>(server->address());
  }
  void End() {
    client.reset();
    server.reset();
    farm.reset();
  }
  // Of a worker in this process.
  Worker::Options WorkerOptions(const std::string& coordinator) const {
    Worker::Options worker;
    worker.coordinator = coordinator;
    worker.threads = 1;
    worker.cache = folder.path() / "cache";
    worker.trial.program = LODESTAR_BINARY_DIR "/bin/lodestar-worker";
    return worker;
  }
  JobId SubmitBox(const JobSpec& spec, const ContentHash& reference = {}) {
    JobSubmission submission;
    submission.name = "box";
    submission.spec = spec;
    submission.scene = client->Upload(box);
    submission.reference = reference;
    return client->SubmitJob(submission);
  }
};

}  // namespace lodestar
