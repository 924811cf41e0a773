// Workers that answer in any order, twice, late, or not at all: the image is the same bits.
#include <random>
#include <thread>

#include "core/learning/contribution.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// Renders what it is given, and then misbehaves: holds results back, shuffles them, sends some twice, drops some,
// splits some in halves, and comes back with those of rounds that are over.
class UnrulyWorker {
 public:
  UnrulyWorker(const std::string& address, const SceneBundle& box, const JobSpec& spec, uint32_t seed)
      : client_(address),
        spec_(spec),
        compiled_(CompileJob(ParsePbrtFile(box.files.front().path), spec)),
        method_(MakeMethod(spec, compiled_.survey)),
        executor_(compiled_.scene, spec, *method_, 1),
        random_(seed) {}

  void Run(const std::atomic<bool>& stop) {
    WorkerInfo info;
    info.build_id = "unruly";
    info.canary = "x";
    id_ = client_.Register(info).id;
    while (!stop) {
      const auto unit = client_.Lease(id_, milliseconds(100));
      if (unit && !unit->render) {
        client_.SubmitSurvey({id_, unit->id, unit->job, compiled_.survey.Serialize(), "", {}});
      } else if (unit && random_() % 8 != 0) {  // some leases are simply forgotten
        Render(*unit);
      }
      if (!unit || held_.size() > 3) Deliver();
    }
  }
  std::map<ContributionOutcome, int> outcomes;
  size_t most_nodes = 0;  // delivered at once

 private:
  struct Result {
    ContributionHeader header;
    Bytes bytes;
  };
  void Render(const LeasedUnit& unit) {
    const RenderUnit& r = *unit.render;
    try {
      if (!states_.contains(r.state.hex)) states_[r.state.hex] = method_->ParseState(client_.FetchState(r.state));
    } catch (const Error&) {
      return;  // that state is over
    }
    std::vector<TreeNode> nodes{r.node};
    if (r.node.level > 0 && random_() % 3 == 0) nodes = {r.node.Child(1), r.node.Child(0)};
    for (const TreeNode node : nodes) {
      if (!node.ValidIn(r.round.unit_count)) continue;
      LeasedUnit part = unit;
      part.render->node = node;
      if (!gathered_.header.Takes(part) || random_() % 4 == 0) Gather();
      gathered_.header.Add(part);
      executor_.ExecuteNode(states_[r.state.hex], r.round, node, StopToken(), &gathered_.contribution);
    }
  }
  // Several leases' work may go out as one.
  void Gather() {
    auto [header, contribution] = std::exchange(gathered_, {});
    if (header.nodes.empty()) return;
    header.worker = id_;
    header.seconds = 0.001;
    most_nodes = std::max(most_nodes, header.nodes.size());
    held_.push_back({header, SerializeContribution(contribution)});
  }
  void Deliver() {
    Gather();
    std::shuffle(held_.begin(), held_.end(), random_);
    if (!old_.empty() && random_() % 2) held_.push_back(old_[random_() % old_.size()]);
    for (const auto& result : held_) {
      for (int i = random_() % 4 == 0 ? 2 : 1; i > 0; --i)
        ++outcomes[client_.SubmitContribution(result.header, result.bytes)];
      old_.push_back(result);
    }
    held_.clear();
  }
  WorkClient client_;
  const JobSpec spec_;
  const CompiledJob compiled_;
  const std::unique_ptr<Method> method_;
  LocalExecutor executor_;
  std::mt19937 random_;
  WorkerId id_;
  std::map<std::string, std::shared_ptr<const State>> states_;
  struct {
    ContributionHeader header;
    Contribution contribution;
  } gathered_;
  std::vector<Result> held_, old_;
};

TEST_F(InProcessFarm, DisorderDoesNotShow) {
  const auto spec = BoxJob("sdtree", 32);
  const auto expected = RenderHere(box, spec);
  size_t most_nodes = 0;
  for (uint32_t seed = 0; seed < 3; ++seed) {
    std::atomic<bool> stop{false};
    std::vector<std::unique_ptr<UnrulyWorker>> workers;
    std::vector<std::jthread> threads;
    for (uint32_t i = 0; i < 1 + seed; ++i)
      workers.push_back(std::make_unique<UnrulyWorker>(server->address(), box, spec, seed * 10 + i));
    for (auto& worker : workers) threads.emplace_back([&] { worker->Run(stop); });
    const auto id = SubmitBox(spec);
    const auto status = client->Watch(id, {});
    stop = true;
    threads.clear();
    ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
    SCOPED_TRACE("seed " + std::to_string(seed));
    ExpectBits(*client, id, expected);
    std::map<ContributionOutcome, int> outcomes;
    for (const auto& worker : workers) {
      for (const auto& [outcome, count] : worker->outcomes) outcomes[outcome] += count;
      most_nodes = std::max(most_nodes, worker->most_nodes);
    }
    EXPECT_GT(outcomes[ContributionOutcome::kCommitted], 0);
    EXPECT_GT(outcomes[ContributionOutcome::kCovered] + outcomes[ContributionOutcome::kStale], 0)
        << "nobody sent anything twice or late";
  }
  EXPECT_GT(most_nodes, 1u);
}

TEST_F(InProcessFarm, ResultsAreTakenOnceAndOnlyWhereTheyBelong) {
  const auto spec = BoxJob("path", 64);
  const auto compiled = CompileJob(ParsePbrtFile(box.files.front().path), spec);
  const auto method = MakeMethod(spec, compiled.survey);
  LocalExecutor executor(compiled.scene, spec, *method, 1);
  WorkClient worker(server->address());
  WorkerInfo info;
  info.build_id = "x";
  const auto id = worker.Register(info).id;
  const auto job = SubmitBox(spec);
  auto unit = worker.Lease(id, seconds(5));
  ASSERT_TRUE(unit && !unit->render);
  worker.SubmitSurvey({id, unit->id, unit->job, compiled.survey.Serialize(), "", {}});
  unit = worker.Lease(id, seconds(5));
  ASSERT_TRUE(unit && unit->render);
  const RenderUnit r = *unit->render;
  const auto state = method->ParseState(worker.FetchState(r.state));
  Contribution contribution;
  executor.ExecuteNode(state, r.round, r.node, StopToken(), &contribution);
  ASSERT_EQ(worker.SubmitContribution({id, {unit->id}, job, r.round, {r.node}, r.state, 0, 0.01},
                                      SerializeContribution(contribution)),
            ContributionOutcome::kCommitted);
  EXPECT_EQ(worker.SubmitContribution({id, {unit->id}, job, r.round, {r.node}, r.state, 0, 0.01},
                                      SerializeContribution(contribution)),
            ContributionOutcome::kCovered);
  auto header = ContributionHeader{id, {unit->id}, job, r.round, {r.node}, Sha256("another state"), 0, 0.01};
  EXPECT_EQ(worker.SubmitContribution(header, SerializeContribution(contribution)), ContributionOutcome::kStale);
  header.state = r.state;
  header.job = {"job-99"};
  EXPECT_EQ(worker.SubmitContribution(header, SerializeContribution(contribution)), ContributionOutcome::kJobEnded);
}

TEST_F(InProcessFarm, AWorkerStopsWithinATenthOfASecond) {
  auto spec = BoxJob("path", 1000000);
  spec.resolution_x = 640;
  spec.resolution_y = 480;
  Worker worker(WorkerOptions(server->address()));
  std::thread thread([&] { worker.Run(); });
  const auto id = SubmitBox(spec);
  EXPECT_TRUE(Eventually(seconds(20), [&] {
    const auto workers = client->Workers();
    return workers.size() == 1 && workers[0].units > 0;
  }));
  client->Cancel(id);
  // It is idle again when it parks for its next lease: nothing it holds is left.
  EXPECT_TRUE(Eventually(seconds(2), [&] {
    return client->GetJob(id).phase == JobPhase::kCancelled && client->Workers()[0].leases == 0;
  }));
  const auto start = std::chrono::steady_clock::now();
  worker.Drain();
  thread.join();
  EXPECT_LT(std::chrono::steady_clock::now() - start, milliseconds(500));
}

}  // namespace
}  // namespace lodestar
