// A disk that fills up while a job runs: what the farm would not take from a client any more it still writes for the
// job.
#include <atomic>

#include "rpc/status.h"
#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

struct FullDisk : InProcessFarm {
  std::atomic<uint64_t> free = uint64_t{1} << 40;
  FullDisk() {
    End();
    options.blobs.free_bytes = [this] { return free.load(); };
    options.checkpoint_interval = options.checkpoint_least = std::chrono::seconds(0);
    Start();
  }
  ~FullDisk() override { End(); }
};

TEST_F(FullDisk, AJobThatRunsEndsWithItsImage) {
  const auto spec = BoxJob("sdtree", 8);
  const auto id = SubmitBox(spec);
  HandWorker worker(server->address(), box, spec);
  bool full = false;
  while (!Ended(client->GetJob(id).phase)) {
    const auto unit = worker.Lease(std::chrono::milliseconds(50));
    if (!unit) continue;
    if (!unit->render) {
      worker.Survey(*unit);
      continue;
    }
    ASSERT_EQ(worker.Render(*unit), ContributionOutcome::kCommitted);
    if (full) continue;
    full = true;
    free = options.blobs.reserve_bytes / 2;
    EXPECT_THROW(SubmitBox(BoxJob("path", 4)), ExhaustedError);
  }
  ASSERT_TRUE(full);
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kDone) << client->GetJob(id).error;
  ExpectBits(*client, id, RenderHere(box, spec));
}

}  // namespace
}  // namespace lodestar
