// A farm of real processes on ports of the system's choice, and what it must agree with.
#pragma once

#include <gtest/gtest.h>

#include <list>
#include <memory>

#include "core/learning/loop.h"
#include "rpc/farm_client.h"
#include "tests/farm/support/process.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {

// The box scene as files in `folder`.
SceneBundle WriteBox(const std::filesystem::path& folder);
JobSpec BoxJob(const std::string& method, uint64_t spp);

// What the image and the hashes must be: the same job in this process.
struct Expected {
  Image image;
  JobReport report;
};
Expected RenderHere(const SceneBundle& bundle, const JobSpec& spec, int threads = 1);
// Bit by bit, NaN or not.
bool SameBits(const Image& a, const Image& b);
// The job has ended with the image and with all that was learned, bit by bit.
void ExpectBits(FarmClient& farm, const JobId& id, const Expected& expected);

class FarmFixture : public testing::Test {
 protected:
  FarmFixture();
  ~FarmFixture() override;
  // Starts it on its old port if it ran before.
  void StartCoordinator(const std::vector<std::string>& environment = {}, const std::vector<std::string>& options = {});
  Process& StartWorker(const std::vector<std::string>& options = {}, int threads = 1);
  FarmClient& client() { return *client_; }
  JobId SubmitBox(const JobSpec& spec, const std::string& name = "box");
  // The job's last status; fails the test where it does not end.
  JobStatus Finish(const JobId& id);
  std::string Log() const;

  TemporaryFolder folder_;
  SceneBundle box_;
  Process coordinator_;
  std::list<Process> workers_;
  std::unique_ptr<FarmClient> client_;
  int port_ = 0;
};

}  // namespace lodestar
