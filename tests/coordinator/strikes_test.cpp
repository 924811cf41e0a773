// A scene that costs its workers' lives must not take the farm with it: after three, its job ends and says why.
#include <sys/stat.h>

#include <thread>

#include "core/base/sha256_stream.h"
#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::seconds;

struct Strikes : InProcessFarm {
  Strikes() : InProcessFarm(true) {}
  // A lease that nobody renews is over, but its worker is not forgotten yet.
  void LoseLeases() { clock.Advance(options.leases.duration + std::chrono::milliseconds(1)); }
  size_t LossesSaid(const JobId& id) {
    size_t count = 0;
    for (const auto& line : client->GetJob(id).log) count += line.starts_with("lost worker-");
    return count;
  }
};

TEST_F(Strikes, ASceneThatHasCostThreeWorkersFailsItsJob) {
  const auto id = SubmitBox(BoxJob("path", 8));
  std::vector<std::unique_ptr<HandWorker>> lost;
  for (size_t i = 1; i <= 3; ++i) {
    EXPECT_EQ(client->GetJob(id).phase, JobPhase::kQueued) << "after " << i - 1;
    lost.push_back(
        std::make_unique<HandWorker>(server->address(), box, BoxJob("path", 8), "unlucky-" + std::to_string(i)));
    const auto unit = lost.back()->Lease();  // to survey the scene, which takes all its memory
    ASSERT_TRUE(unit && !unit->render);
    LoseLeases();
    ASSERT_TRUE(Eventually(seconds(10), [&] { return LossesSaid(id) == i; }));
  }
  ASSERT_TRUE(Eventually(seconds(10), [&] { return Ended(client->GetJob(id).phase); }));
  const auto status = client->GetJob(id);
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  EXPECT_NE(status.error.find("3 workers were lost"), std::string::npos) << status.error;
  EXPECT_NE(status.error.find("memory"), std::string::npos) << status.error;
  for (size_t i = 1; i <= 3; ++i) {
    EXPECT_NE(status.log[i - 1].find("unlucky-" + std::to_string(i)), std::string::npos) << status.log[i - 1];
  }
  EXPECT_EQ(status.log.back(), status.error);
  // It is remembered, and the queue goes on.
  End();
  Start();
  EXPECT_EQ(client->GetJob(id).error, status.error);
  EXPECT_EQ(client->GetJob(id).log, status.log);
  const auto next = SubmitBox(BoxJob("path", 8));
  HandWorker worker(server->address(), box, BoxJob("path", 8));
  const auto unit = worker.Lease();
  ASSERT_TRUE(unit);
  EXPECT_EQ(unit->job, next);
}

TEST_F(Strikes, LossesCountOnceAtATimeAndNotBeyondAResult) {
  const auto spec = BoxJob("path", 8);
  const auto id = SubmitBox(spec);
  HandWorker first(server->address(), box, spec, "first");
  const auto survey = first.Lease();
  ASSERT_TRUE(survey && !survey->render);
  first.Survey(*survey);
  auto unit = first.Lease();
  ASSERT_TRUE(unit && unit->render);
  size_t said = 0;
  const auto lose = [&](int workers) {
    std::vector<std::unique_ptr<HandWorker>> lost;
    for (int i = 0; i < workers; ++i) {
      lost.push_back(std::make_unique<HandWorker>(server->address(), box, spec, "unlucky"));
      const auto lease = lost.back()->Lease();
      ASSERT_TRUE(lease && lease->render);
    }
    LoseLeases();
    ++said;
    ASSERT_TRUE(Eventually(seconds(10), [&] { return LossesSaid(id) == said; }));
  };
  lose(3);  // together with the first one's lease: a switch, or a power cut
  lose(1);
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kRunning);
  EXPECT_EQ(first.Render(*unit), ContributionOutcome::kCommitted) << "late, and taken all the same";
  lose(1);
  EXPECT_EQ(first.Render(*unit), ContributionOutcome::kCovered) << "again, which finishes nothing";
  lose(1);
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kRunning) << "a result came in between";
  lose(1);
  ASSERT_TRUE(Eventually(seconds(10), [&] { return Ended(client->GetJob(id).phase); }));
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kFailed);
}

TEST_F(Strikes, AFailedJobKeepsTheImageOfItsRounds) {
  auto spec = BoxJob("path", 1000000);
  const auto id = SubmitBox(spec);
  {
    HandWorker worker(server->address(), box, spec, "first");
    const auto survey = worker.Lease();
    ASSERT_TRUE(survey && !survey->render);
    worker.Survey(*survey);
    EXPECT_THROW(client->GetImage(id), Error) << "nothing has been rendered";
    while (client->GetJob(id).progress.passes < 3) {
      const auto unit = worker.Lease();
      ASSERT_TRUE(unit);
      worker.Render(*unit);
    }
    ASSERT_TRUE(worker.Lease());
  }
  for (size_t said = 1; said <= 3; ++said) {
    LoseLeases();
    ASSERT_TRUE(Eventually(seconds(10), [&] { return LossesSaid(id) == said; }));
    if (said == 3) break;
    ASSERT_TRUE(HandWorker(server->address(), box, spec, "unlucky").Lease());
  }
  const auto status = client->Watch(id, {});
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  spec.budget.spp = status.progress.passes;
  const auto expected = RenderHere(box, spec);
  for (const char* when : {"now", "after a restart"}) {
    EXPECT_TRUE(SameBits(client->GetImage(id), expected.image)) << when;
    EXPECT_NE(client->GetReport(id).find(expected.report.image_hash.hex), std::string::npos) << when;
    EXPECT_EQ(client->GetJob(id).log.back(), status.error) << when;
    End();
    Start();
  }
}

TEST_F(InProcessFarm, WhatAWorkerCannotDoIsLeftToOthers) {
  End();
  options.leases.duration = seconds(60);
  Start();
  const auto spec = BoxJob("path", 8);
  const auto id = SubmitBox(spec);
  HandWorker small(server->address(), box, spec, "small"), large(server->address(), box, spec, "large");
  auto unit = small.Lease();
  ASSERT_TRUE(unit && !unit->render);
  small.Fail(*unit, "compiling box.pbrt takes more than 1 MiB");
  EXPECT_FALSE(small.Lease(std::chrono::milliseconds(50))) << "there is another";
  unit = large.Lease();
  ASSERT_TRUE(unit && !unit->render);
  large.Survey(*unit);
  unit = large.Lease();
  ASSERT_TRUE(unit && unit->render);
  EXPECT_FALSE(small.Lease(std::chrono::milliseconds(50)));
  // Left alone with it, it is asked again; and the third time ends the job, with its reason.
  large.Fail(*unit, "disk full");
  ASSERT_TRUE(unit = small.Lease());
  small.Fail(*unit, "compiling box.pbrt takes more than 1 MiB");
  const auto status = client->Watch(id, {});
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  EXPECT_NE(status.error.find("box.pbrt"), std::string::npos) << status.error;
  EXPECT_EQ(status.log[1], "large: disk full");
}

TEST_F(InProcessFarm, AWorkersCacheIsNoFaultOfTheScene) {
  const auto spec = BoxJob("path", 8);
  HandWorker sound(server->address(), box, spec, "sound");
  const auto id = SubmitBox(spec);
  auto broken_options = WorkerOptions(server->address());
  broken_options.name = "broken";
  for (const auto& file : box.files) {
    const std::string hash = Sha256OfFile(file.path).hex;
    const auto kept = broken_options.cache / "content" / hash.substr(0, 2) / hash;
    std::filesystem::create_directories(kept.parent_path());
    ASSERT_EQ(mknod(kept.c_str(), S_IFSOCK | 0600, 0), 0);  // which not even root can open
  }
  Worker broken(broken_options);
  std::thread thread([&] { broken.Run(); });
  const bool said = Eventually(seconds(30), [&] { return !client->GetJob(id).log.empty(); });
  const auto status = client->GetJob(id);
  if (const auto unit = sound.Lease(); unit && !unit->render) sound.Survey(*unit);
  const bool begun = Eventually(seconds(10), [&] { return client->GetJob(id).phase == JobPhase::kRunning; });
  broken.Drain();
  thread.join();
  ASSERT_TRUE(said);
  EXPECT_EQ(status.log[0].find("broken: "), 0u) << status.log[0];
  EXPECT_EQ(status.phase, JobPhase::kQueued) << status.error;
  EXPECT_TRUE(begun);
}

// An init system may end all of a service's processes at once.
TEST_F(InProcessFarm, AWorkerThatIsEndedWithItsChildGivesTheSceneBack) {
  auto worker_options = WorkerOptions(server->address());
  worker_options.trial.program =
      folder.Write("program", "#!/bin/sh\ncd " + folder.path().string() +
                                  "\ntouch tried\nuntil test -e ended; do sleep 0.01; done\nkill -TERM $$\n");
  std::filesystem::permissions(worker_options.trial.program, std::filesystem::perms::owner_all);
  const auto id = SubmitBox(BoxJob("path", 8));
  Worker worker(worker_options);
  std::thread thread([&] { worker.Run(); });
  const bool tried = Eventually(seconds(30), [&] { return std::filesystem::exists(folder / "tried"); });
  worker.Drain();
  folder.Write("ended", "");
  thread.join();
  ASSERT_TRUE(tried);
  EXPECT_TRUE(client->GetJob(id).log.empty()) << client->GetJob(id).log[0];
  HandWorker next(server->address(), box, BoxJob("path", 8), "next");
  const auto unit = next.Lease();
  EXPECT_TRUE(unit && !unit->render) << "given back at once";
}

}  // namespace
}  // namespace lodestar
