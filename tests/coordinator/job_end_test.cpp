// What an ended job leaves behind, and what one that has not begun does not keep anybody waiting for.
#include <fstream>
#include <future>

#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::seconds;

struct JobEnd : InProcessFarm {
  JobEnd() : InProcessFarm(true) {
    End();
    options.checkpoint_interval = options.checkpoint_least = seconds(0);
    Start();
  }
  // The row of the only job.
  std::string StoredCheckpoint() {
    Database database(options.store / "jobs.sqlite");
    Statement row(database, "SELECT checkpoint FROM jobs");
    return row.Step() ? row.Text(0) : "";
  }
  void Survey(HandWorker& worker) {
    const auto unit = worker.Lease();
    ASSERT_TRUE(unit && !unit->render);
    worker.Survey(*unit);
  }
  // Until the job has a round.
  void FirstRound(HandWorker& worker, const JobId& id) {
    Survey(worker);
    while (client->GetJob(id).progress.passes == 0) {
      const auto unit = worker.Lease();
      ASSERT_TRUE(unit && unit->render);
      ASSERT_EQ(worker.Render(*unit), ContributionOutcome::kCommitted);
    }
  }
};

TEST_F(JobEnd, NoCheckpointStaysOfAJobThatEndsWithoutAnImage) {
  const auto spec = BoxJob("path", 8);
  const auto id = SubmitBox(spec);
  HandWorker worker(server->address(), box, spec);
  Survey(worker);
  const auto unit = worker.Lease();
  ASSERT_TRUE(unit && unit->render);
  ASSERT_EQ(worker.Render(*unit), ContributionOutcome::kCommitted);
  ASSERT_EQ(client->GetJob(id).progress.passes, 0u) << "a part of its first round";
  ContentHash checkpoint;
  ASSERT_TRUE(Eventually(seconds(10), [&] { return !(checkpoint.hex = StoredCheckpoint()).empty(); }));
  client->Cancel(id);
  ASSERT_EQ(client->Watch(id, {}).phase, JobPhase::kCancelled);
  EXPECT_EQ(StoredCheckpoint(), "");
  // The one seen above may have had a successor: no blob may be left but the job's description and its scene's files.
  size_t blobs = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(options.store / "blobs"))
    blobs += entry.is_regular_file();
  EXPECT_EQ(blobs, 1 + box.files.size());
}

// Else its picture would be shown, which is black.
TEST_F(JobEnd, AJobThatBeginsAgainHasNoProgress) {
  const auto spec = BoxJob("sdtree", 64);
  const auto id = SubmitBox(spec);
  {
    HandWorker worker(server->address(), box, spec);
    FirstRound(worker, id);
  }
  End();
  const std::string hash = StoredCheckpoint();
  ASSERT_NE(hash, "");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(options.store / "blobs"))
    if (entry.path().filename() == hash) std::ofstream(entry.path()) << "not a checkpoint";
  Start();
  ASSERT_TRUE(Eventually(seconds(10), [&] { return client->GetJob(id).progress.passes == 0; }));
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kRunning);
}

TEST_F(JobEnd, PicturesShownWhileAJobRanAreNotKept) {
  const auto spec = BoxJob("path", 1000000);
  const auto id = SubmitBox(spec);
  HandWorker worker(server->address(), box, spec);
  FirstRound(worker, id);
  const std::weak_ptr<const Image> shown = farm->GetImage(id);
  EXPECT_FALSE(shown.expired()) << "it is kept for the next who asks";
  client->Cancel(id);
  ASSERT_EQ(client->Watch(id, {}).phase, JobPhase::kCancelled);
  EXPECT_TRUE(shown.expired());
  EXPECT_EQ(farm->GetImage(id)->width, 64u);
  EXPECT_NE(farm->GetReport(id).find("image_sha256"), std::string::npos);
}

// By the farm's clock, which stands still: who waits for time to pass waits for ever.
TEST_F(JobEnd, NobodyWaitsForAJobThatHasNothingToShow) {
  const auto spec = BoxJob("path", 8);
  const auto id = SubmitBox(spec);
  HandWorker worker(server->address(), box, spec);
  Survey(worker);
  ASSERT_TRUE(Eventually(seconds(10), [&] { return client->GetJob(id).phase == JobPhase::kRunning; }));
  for (const bool image : {true, false}) {
    auto answer = std::async(std::launch::async, [&] {
      if (image) {
        farm->GetImage(id);
      } else {
        farm->GetReport(id);
      }
    });
    const bool waits = answer.wait_for(seconds(10)) != std::future_status::ready;
    EXPECT_FALSE(waits) << (image ? "image" : "report");
    if (waits) clock.Advance(seconds(6));  // or this test would wait, too
    EXPECT_THROW(answer.get(), Error);
  }
}

}  // namespace
}  // namespace lodestar
