// Kill, stop, restart: the image is the same bits, and nothing hangs.
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <future>

#include "coordinator/crash_point.h"
#include "tests/farm/support/farm_fixture.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class FarmFailure : public FarmFixture {
 protected:
  void WaitForPasses(const JobId& id, uint64_t passes) {
    ASSERT_TRUE(Eventually(seconds(30), [&] {
      const auto status = client().GetJob(id);
      return status.progress.passes >= passes || Ended(status.phase);
    }));
  }
  void ExpectSame(const JobId& id, const JobSpec& spec) {
    const auto status = Finish(id);
    ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
    ExpectBits(client(), id, RenderHere(box_, spec));
  }
};

class FarmCrash : public FarmFailure, public testing::WithParamInterface<std::string> {};

TEST_P(FarmCrash, ResumesWithTheSameBits) {
  StartCoordinator({"LODESTAR_CRASH_AT=" + GetParam()}, {"--checkpoint", "0.01"});
  ASSERT_FALSE(HasFailure());
  StartWorker();
  StartWorker();
  // Processes end with the thread that started them, so it is the client that moves to another one.
  // Checkpoints are written beside rendering, at the disk's pace: a later one needs a job that lasts until then.
  const auto spec = BoxJob("sdtree", GetParam().ends_with(":1") ? 48 : 400);
  JobId id;
  auto done = std::async(std::launch::async, [&] {
    id = SubmitBox(spec);
    return Finish(id);
  });
  const int code = coordinator_.Wait(seconds(40));
  if (code >= 0) StartCoordinator({}, {"--checkpoint", "0.01"});
  const auto status = done.get();
  EXPECT_EQ(code, 128 + SIGKILL) << "the crash point was not reached";
  EXPECT_EQ(status.phase, JobPhase::kDone) << status.error;
  ExpectBits(client(), id, RenderHere(box_, spec));
  EXPECT_EQ(client().ListJobs().size(), 1u) << "repeated submits made more than one job";
}
std::vector<std::string> AllCrashes() {
  std::vector<std::string> all;
  for (const char* name : CrashPoints()) all.push_back(std::string(name) + ":1");
  // Later passages: the description of the job, a second checkpoint, a merge in the midst of training.
  for (const char* name : {"blob-renamed:3", "checkpoint-blob:3", "checkpoint-committed:2", "contribution-merged:6"})
    all.push_back(name);
  return all;
}
INSTANTIATE_TEST_SUITE_P(At, FarmCrash, testing::ValuesIn(AllCrashes()), [](const auto& info) {
  std::string name = info.param;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

TEST_F(FarmFailure, AKilledWorkerCostsNothingButTime) {
  StartCoordinator();
  StartWorker();
  const auto spec = BoxJob("sdtree", 256);
  const auto id = SubmitBox(spec);
  WaitForPasses(id, 4);
  workers_.front().Kill();
  const auto before = client().GetJob(id);
  ASSERT_EQ(before.phase, JobPhase::kRunning) << "the job was over before its worker was";
  StartWorker();
  StartWorker();
  ExpectSame(id, spec);
}

TEST_F(FarmFailure, AStoppedWorkerIsOvertakenAndItsLateResultDropped) {
  StartCoordinator();
  auto& slow = StartWorker();
  const auto spec = BoxJob("sdtree", 256);
  const auto id = SubmitBox(spec);
  WaitForPasses(id, 4);
  slow.Signal(SIGSTOP);
  ASSERT_EQ(client().GetJob(id).phase, JobPhase::kRunning);
  StartWorker();
  ExpectSame(id, spec);
  slow.Signal(SIGCONT);
  // It lives on and takes part in the next job.
  workers_.back().Kill();
  const auto next = SubmitBox(BoxJob("path", 8), "next");
  EXPECT_EQ(Finish(next).phase, JobPhase::kDone);
}

TEST_F(FarmFailure, WorkersOutliveTheirCoordinator) {
  StartCoordinator();
  StartWorker();
  StartWorker();
  const auto spec = BoxJob("sdtree", 256);
  const auto id = SubmitBox(spec);
  WaitForPasses(id, 2);
  coordinator_.Kill();
  StartCoordinator();
  ExpectSame(id, spec);
  for (auto& worker : workers_) EXPECT_TRUE(worker.running());
}

TEST_F(FarmFailure, ACoordinatorEndsInOrderAndGoesOn) {
  StartCoordinator();
  StartWorker();
  const auto spec = BoxJob("sdtree", 256);
  const auto id = SubmitBox(spec);
  WaitForPasses(id, 8);
  const auto passes = client().GetJob(id).progress.passes;
  coordinator_.Signal(SIGTERM);
  ASSERT_EQ(coordinator_.Wait(seconds(10)), 0);
  StartCoordinator();
  EXPECT_GE(client().GetJob(id).progress.passes, passes) << "it did not store its position at its end";
  ExpectSame(id, spec);
}

TEST_F(FarmFailure, ATermSignalDrainsAWorker) {
  StartCoordinator();
  auto& first = StartWorker();
  const auto spec = BoxJob("sdtree", 256);
  const auto id = SubmitBox(spec);
  WaitForPasses(id, 4);
  first.Signal(SIGTERM);
  EXPECT_EQ(first.Wait(seconds(10)), 0);
  StartWorker();
  ExpectSame(id, spec);
}

TEST_F(FarmFailure, CancelStopsQuicklyAndKeepsTheImage) {
  StartCoordinator();
  StartWorker();
  const auto id = SubmitBox(BoxJob("sdtree", 1000000));
  WaitForPasses(id, 2);
  EXPECT_EQ(client().GetImage(id).width, 64u) << "the image so far, of a running job";
  EXPECT_GE(client().GetGuide(id).iterations, 1u) << "what it has learned so far";
  const auto start = std::chrono::steady_clock::now();
  client().Cancel(id);
  EXPECT_EQ(Finish(id).phase, JobPhase::kCancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(5));
  EXPECT_EQ(client().GetImage(id).width, 64u);
  EXPECT_GE(client().GetGuide(id).iterations, 1u);
  const auto next = SubmitBox(BoxJob("path", 4), "next");
  EXPECT_EQ(Finish(next).phase, JobPhase::kDone) << "the worker is free again";
}

TEST_F(FarmFailure, ASecondCoordinatorOfAStoreIsRefused) {
  StartCoordinator();
  StartWorker();
  const auto spec = BoxJob("sdtree", 256);
  const auto id = SubmitBox(spec);
  WaitForPasses(id, 2);
  const auto store = folder_.path() / "store";
  for (const int port : {0, port_}) {
    Process second({LODESTAR_BINARY_DIR "/bin/lodestar-coordinator", "--listen", "127.0.0.1:" + std::to_string(port),
                    "--store", store.string()},
                   folder_.path() / "coordinator.log");
    EXPECT_EQ(second.Wait(seconds(10)), 1) << port;
  }
  EXPECT_NE(Log().find("another coordinator of this machine holds the store " + store.string()), std::string::npos);
  ExpectSame(id, spec);
  EXPECT_TRUE(coordinator_.running());
}

TEST_F(FarmFailure, AWrongAddressLeavesTheStoreAlone) {
  const auto store = folder_.path() / "store";
  Process refused({LODESTAR_BINARY_DIR "/bin/lodestar-coordinator", "--listen", "nowhere", "--store", store.string()},
                  folder_.path() / "coordinator.log");
  EXPECT_EQ(refused.Wait(seconds(10)), 1);
  EXPECT_FALSE(std::filesystem::exists(store));
}

TEST_F(FarmFailure, ACoordinatorWhoseStoreIsTakenOverEndsByItself) {
  StartCoordinator({}, {"--checkpoint", "0.1"});
  StartWorker();
  const auto id = SubmitBox(BoxJob("path", 1000000));
  WaitForPasses(id, 2);
  // Another machine's coordinator sees no lock of this one's: the old one is fenced, and its next checkpoint tells it.
  Process old = std::move(coordinator_);
  const int old_port = std::exchange(port_, 0);
  client_ = nullptr;
  std::filesystem::remove(folder_.path() / "store" / "lock");
  StartCoordinator();
  EXPECT_NE(port_, old_port);
  EXPECT_EQ(old.Wait(seconds(20)), 4);
}

TEST_F(FarmFailure, ASceneInErrorFailsItsJobAlone) {
  StartCoordinator();
  StartWorker();
  StartWorker();
  const auto good = SubmitBox(BoxJob("path", 4), "good");
  auto broken = box_;
  const auto file = folder_.path() / "scene" / "broken.pbrt";
  { std::ofstream(file) << "Camera \"perspective\"\nWorldBegin\nShape \"sphree\"\n"; }
  broken = BundleScene({file.string()});
  JobSubmission submission;
  submission.name = "broken";
  submission.spec = BoxJob("path", 4);
  submission.scene = client().Upload(broken);
  const auto bad = client().SubmitJob(submission);
  const auto after = SubmitBox(BoxJob("path", 4), "after");
  const auto status = Finish(bad);
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  EXPECT_NE(status.error.find("broken.pbrt:3:"), std::string::npos) << status.error;
  EXPECT_EQ(status.error.find(folder_.path().string()), std::string::npos) << "no paths of the worker's";
  EXPECT_FALSE(status.log.empty());
  EXPECT_EQ(Finish(good).phase, JobPhase::kDone);
  EXPECT_EQ(Finish(after).phase, JobPhase::kDone);
}

// Two small files that together ask for a million spheres, a thousand times what the worker may take for a scene.
TEST_F(FarmFailure, ASceneThatTakesAllMemoryCostsItsJobAndNotTheWorker) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need more memory than such a limit leaves, and the worker sets none";
#endif
  StartCoordinator();
  auto& worker = StartWorker({"--scene-memory", "500"});
  const auto folder = folder_.path() / "scene";
  std::ofstream(folder / "many.pbrt") << "Camera \"perspective\"\nWorldBegin\n";
  {
    std::ofstream many(folder / "many.pbrt", std::ios::app), thousand(folder / "thousand.pbrt");
    for (int i = 0; i < 20000; ++i) {
      many << "Include \"thousand.pbrt\"\n";
      if (i < 1000) thousand << "Shape \"sphere\"\n";
    }
  }
  JobSubmission submission;
  submission.name = "many";
  submission.spec = BoxJob("path", 4);
  submission.scene =
      client().Upload(BundleScene({(folder / "many.pbrt").string(), (folder / "thousand.pbrt").string()}));
  const auto status = Finish(client().SubmitJob(submission));
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  EXPECT_NE(status.error.find("many.pbrt takes more than the 500 MiB"), std::string::npos) << status.error;
  EXPECT_EQ(std::count_if(status.log.begin(), status.log.end(),
                          [](const std::string& line) { return line.find("many.pbrt") != std::string::npos; }),
            4)
      << "three strikes, and the end";
  EXPECT_TRUE(worker.running());
  ExpectSame(SubmitBox(BoxJob("path", 4), "after"), BoxJob("path", 4));
  EXPECT_TRUE(worker.running());
}

TEST_F(FarmFailure, ListensOffLoopbackOnlyWhenTold) {
  for (const char* listen : {"0.0.0.0:0", "127.evil.example:0", "[::]:0"}) {
    Process refused({LODESTAR_BINARY_DIR "/bin/lodestar-coordinator", "--listen", listen, "--store",
                     (folder_.path() / "other").string()},
                    folder_.path() / "coordinator.log");
    EXPECT_EQ(refused.Wait(seconds(10)), 1) << listen;
  }
  EXPECT_NE(Log().find("--insecure"), std::string::npos);
}

}  // namespace
}  // namespace lodestar
