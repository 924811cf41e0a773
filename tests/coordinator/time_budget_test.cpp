// A job by time pays for the work on it, not for the wait while another job has the workers.
#include <future>

#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

struct TimeBudget : InProcessFarm {
  TimeBudget() : InProcessFarm(true) {
    End();
    options.leases.duration = seconds(1000);  // nobody is given up while the time is moved
    Start();
  }
  double SecondsOf(const JobId& id) { return client->GetJob(id).progress.seconds; }
};

TEST_F(TimeBudget, WaitingForWorkersIsFree) {
  const auto first = SubmitBox(BoxJob("path", 1000000));
  auto spec = BoxJob("path", 1000000);
  spec.budget.seconds = 60;
  const auto timed = SubmitBox(spec);
  HandWorker worker(server->address(), box, spec);
  for (const auto& id : {first, timed}) {
    const auto unit = worker.Lease();
    ASSERT_TRUE(unit && !unit->render);
    ASSERT_EQ(unit->job, id);
    worker.Survey(*unit);
  }
  // Both run: the older one has the worker, until all of its units are out. The other gets one unit done, and waits.
  while (true) {
    const auto unit = worker.Lease();
    ASSERT_TRUE(unit && unit->render);
    if (unit->job == first) continue;
    ASSERT_EQ(worker.Render(*unit), ContributionOutcome::kCommitted);
    break;
  }
  clock.Advance(seconds(100));
  client->Cancel(first);
  ASSERT_EQ(client->Watch(first, {}).phase, JobPhase::kCancelled);
  int leases = 0;
  for (; client->GetJob(timed).progress.passes == 0; ++leases) {
    const auto unit = worker.Lease();
    ASSERT_TRUE(unit && unit->render);
    ASSERT_EQ(unit->job, timed);
    clock.Advance(milliseconds(100));
    ASSERT_EQ(worker.Render(*unit), ContributionOutcome::kCommitted);
  }
  EXPECT_EQ(client->GetJob(timed).phase, JobPhase::kRunning);
  EXPECT_GT(SecondsOf(timed), 0);
  EXPECT_LE(SecondsOf(timed), 0.1 * leases + 1e-9);
  // What is worked counts: a single lease takes longer than the budget.
  while (!Ended(client->GetJob(timed).phase)) {
    // It is waited for by the farm's clock.
    auto lease = std::async(std::launch::async, [&] { return worker.Lease(milliseconds(50)); });
    while (lease.wait_for(milliseconds(10)) != std::future_status::ready) clock.Advance(milliseconds(50));
    const auto unit = lease.get();
    if (!unit) continue;
    clock.Advance(seconds(61));
    worker.Render(*unit);
  }
  EXPECT_EQ(client->GetJob(timed).phase, JobPhase::kDone);
  EXPECT_NE(client->GetReport(timed).find("\"stop_reason\":\"time\""), std::string::npos);
  EXPECT_GT(SecondsOf(timed), 60);
}

}  // namespace
}  // namespace lodestar
