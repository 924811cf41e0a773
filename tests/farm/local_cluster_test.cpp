// deploy/local-cluster.sh: a farm in one command, which ends what it has started.
#include <signal.h>

#include <fstream>
#include <regex>

#include "tests/farm/support/farm_fixture.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using std::chrono::seconds;

std::string Read(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST(LocalCluster, RendersAJobAndEndsWhatItStarted) {
  TemporaryFolder folder;
  const auto log = folder.path() / "log", store = folder.path() / "store";
  Process cluster({LODESTAR_SOURCE_DIR "/deploy/local-cluster.sh", "2", "1"}, log,
                  {"LODESTAR_BIN=" LODESTAR_BINARY_DIR "/bin", "LODESTAR_STORE=" + store.string()});
  std::smatch address;
  std::string said;
  ASSERT_TRUE(Eventually(seconds(30), [&] {
    said = Read(log);
    return !cluster.running() ||
           std::regex_search(said, address, std::regex("LODESTAR_FARM=(127\\.0\\.0\\.1:[0-9]+);"));
  }));
  ASSERT_FALSE(address.empty()) << said;
  FarmClient client(address[1].str(), FarmClient::Options{30});
  const auto box = WriteBox(folder.path() / "scene");
  JobSubmission submission;
  submission.name = "box";
  submission.spec = BoxJob("path", 4);
  submission.scene = client.Upload(box);
  const auto status = client.Watch(client.SubmitJob(submission), {});
  EXPECT_EQ(status.phase, JobPhase::kDone) << status.error;
  EXPECT_TRUE(Eventually(seconds(10), [&] { return client.Workers().size() == 2; }));
  cluster.Signal(SIGTERM);
  EXPECT_EQ(cluster.Wait(seconds(20)), 0);
  EXPECT_THROW(FarmClient(address[1].str(), FarmClient::Options{0}).ListJobs(), Error) << "the coordinator lives on";
  for (const char* name : {"worker-1.log", "worker-2.log"})
    EXPECT_NE(Read(store / name).find("rendered"), std::string::npos) << name << ": no orderly end";
  EXPECT_NE(Read(store / "coordinator.log").find("ending on signal"), std::string::npos);
}

TEST(LocalCluster, SaysWhyItDoesNotStart) {
  TemporaryFolder folder;
  const auto log = folder.path() / "log";
  Process cluster({LODESTAR_SOURCE_DIR "/deploy/local-cluster.sh"}, log,
                  {"LODESTAR_BIN=" + folder.path().string(), "LODESTAR_STORE=" + (folder.path() / "s").string()});
  EXPECT_EQ(cluster.Wait(seconds(10)), 1);
  EXPECT_NE(Read(log).find("scripts/"), std::string::npos) << "what to do: " << Read(log);
}

}  // namespace
}  // namespace lodestar
