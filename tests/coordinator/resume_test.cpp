// What a checkpoint held of a round under way is not rendered again.
#include <set>

#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::seconds;

class Resume : public InProcessFarm, public testing::WithParamInterface<bool> {};

// Orderly: the coordinator is told to end within a round. Else a successor takes its store over without asking, as
// after a crash, and finds the last checkpoint.
TEST_P(Resume, CheckpointedPartsAreNotRenderedAgain) {
  const bool orderly = GetParam();
  End();
  options.checkpoint_interval = orderly ? seconds(1000) : seconds(0);
  options.checkpoint_least = options.checkpoint_interval;
  Start();
  const auto spec = BoxJob("sdtree", 32);
  const auto id = SubmitBox(spec);
  std::optional<Round> round;  // the first of iteration 1: it has a state that was learned
  std::set<uint32_t> before, after;
  {
    HandWorker worker(server->address(), box, spec);
    while (before.size() < 4) {
      const auto unit = worker.Lease();
      ASSERT_TRUE(unit);
      if (!unit->render) {
        worker.Survey(*unit);
        continue;
      }
      ASSERT_EQ(worker.Render(*unit), ContributionOutcome::kCommitted);
      if (unit->render->round.iteration == 0) continue;
      if (!round) round = unit->render->round;
      ASSERT_EQ(unit->render->round, *round);
      for (uint32_t u = unit->render->node.first(); u < unit->render->node.end(round->unit_count); ++u)
        before.insert(u);
    }
    ASSERT_LT(before.size(), round->unit_count);
  }
  std::unique_ptr<Farm> old;
  if (orderly) {
    End();
  } else {
    // The position as a successor would find it.
    const auto stored = [&] {
      const auto copy = folder.path() / "copy.sqlite";
      std::filesystem::copy_file(options.store / "jobs.sqlite", copy,
                                 std::filesystem::copy_options::overwrite_existing);
      try {
        Database database(copy);
        Statement row(database, "SELECT checkpoint FROM jobs");
        if (!row.Step() || row.Text(0).empty()) return false;
        const std::string hash = row.Text(0);
        const auto position = JobCheckpoint::Parse(farm->blobs().Read({hash}));
        uint32_t units = 0;
        for (const TreeNode node : position.nodes) units += node.end(round->unit_count) - node.first();
        return position.round == *round && units == before.size();
      } catch (const Error&) {
        return false;  // between two commits
      }
    };
    ASSERT_TRUE(Eventually(seconds(10), stored));
    client.reset();
    server.reset();
    old = std::move(farm);
    std::filesystem::remove(options.store / "lock");  // a crash would have given it up
  }
  Start();
  HandWorker worker(server->address(), box, spec);
  while (!Ended(client->GetJob(id).phase)) {
    const auto unit = worker.Lease(std::chrono::milliseconds(50));
    if (!unit) continue;
    ASSERT_TRUE(unit->render) << "the survey is stored";
    ASSERT_GE(unit->render->round.iteration, 1u);
    const auto outcome = worker.Render(*unit);
    ASSERT_EQ(outcome, ContributionOutcome::kCommitted);
    if (unit->render->round != *round) continue;
    for (uint32_t u = unit->render->node.first(); u < unit->render->node.end(round->unit_count); ++u) {
      EXPECT_FALSE(before.contains(u)) << "unit " << u << " was rendered again";
      after.insert(u);
    }
  }
  EXPECT_EQ(before.size() + after.size(), round->unit_count);
  ExpectBits(*client, id, RenderHere(box, spec));
}
INSTANTIATE_TEST_SUITE_P(After, Resume, testing::Bool(),
                         [](const auto& info) { return info.param ? "AnOrderlyEnd" : "ACrash"; });

}  // namespace
}  // namespace lodestar
