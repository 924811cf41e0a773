// Advances that workers share in: nobody sees from the result who made which tree.
#include <cstring>
#include <thread>

#include "core/guiding/tree_request.h"
#include "core/learning/contribution.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "tests/coordinator/in_process_farm.h"
#include "tests/support/resealed.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// Several shards an iteration: many leaves, fine trees.
JobSpec ManyTrees(const std::string& reconstruction) {
  JobSpec spec = BoxJob("sdtree", 31);
  spec.resolution_x = 128;
  spec.resolution_y = 96;
  spec.training_iterations = 4;
  spec.options = {{"spatial-threshold", "200"}, {"flux-threshold", "0.002"}, {"reconstruction", reconstruction}};
  return spec;
}

struct Shards : InProcessFarm {
  Shards() {
    End();
    options.alone_share = -1;  // every advance is offered, from its first shard on
    Start();
  }
};

// Does what it is told, but with shards whatever `answer` makes of them.
class ShardWorker {
 public:
  using Answer = std::function<std::optional<Bytes>(const ShardUnit&)>;
  ShardWorker(const std::string& address, const SceneBundle& box, const JobSpec& spec, Answer answer,
              const std::string& tree_canary = TreeCanary())
      : client_(address),
        compiled_(CompileJob(ParsePbrtFile(box.files.front().path), spec)),
        method_(MakeMethod(spec, compiled_.survey)),
        executor_(compiled_.scene, spec, *method_, 1),
        answer_(std::move(answer)) {
    WorkerInfo info;
    info.build_id = "shards";
    info.tree_canary = tree_canary;
    id_ = client_.Register(info).id;
  }
  void Run(const std::atomic<bool>& stop) {
    while (!stop) {
      const auto unit = client_.Lease(id_, milliseconds(100));
      if (!unit) continue;
      if (unit->render) {
        Render(*unit);
      } else if (unit->shard) {
        ++shards;
        try {
          if (const auto trees = answer_(*unit->shard)) client_.SubmitShard({id_, unit->id, unit->job, *trees});
        } catch (const Error& error) {
          EXPECT_EQ(error.kind(), ErrorKind::kCorrupt) << error.what();
          ++refused;
        }
      } else {
        client_.SubmitSurvey({id_, unit->id, unit->job, compiled_.survey.Serialize(), "", {}});
      }
    }
  }
  int shards = 0, refused = 0;

 private:
  void Render(const LeasedUnit& unit) {
    const RenderUnit& r = *unit.render;
    try {
      if (state_hash_ != r.state) state_ = method_->ParseState(client_.FetchState(r.state));
    } catch (const Error&) {
      return;  // that state is over
    }
    state_hash_ = r.state;
    Contribution contribution;
    executor_.ExecuteNode(state_, r.round, r.node, StopToken(), &contribution);
    client_.SubmitContribution({id_, {unit.id}, unit.job, r.round, {r.node}, r.state, 0, 0.01},
                               SerializeContribution(contribution));
  }
  WorkClient client_;
  const CompiledJob compiled_;
  const std::unique_ptr<Method> method_;
  LocalExecutor executor_;
  const Answer answer_;
  WorkerId id_;
  ContentHash state_hash_;
  std::shared_ptr<const State> state_;
};

TEST_F(Shards, WhoMadeWhichTreeDoesNotShow) {
  struct Case {
    const char* what;
    ShardWorker::Answer answer;
  };
  const Case cases[] = {
      {"answers", [](const ShardUnit& unit) { return AnswerTreeRequest(unit.request); }},
      {"forgets", [](const ShardUnit&) { return std::nullopt; }},
      {"is of no use", [](const ShardUnit&) { return "trees of another kind"; }},
      {"is late",
       [](const ShardUnit& unit) {
         std::this_thread::sleep_for(milliseconds(100));
         return AnswerTreeRequest(unit.request);
       }},
  };
  for (const char* reconstruction : {"dense", "dense-unlimited"}) {
    const auto spec = ManyTrees(reconstruction);
    const auto expected = RenderHere(box, spec);
    for (const Case& c : cases) {
      SCOPED_TRACE(std::string(reconstruction) + ", a worker that " + c.what);
      std::atomic<bool> stop{false};
      ShardWorker worker(server->address(), box, spec, c.answer);
      std::jthread thread([&] { worker.Run(stop); });
      const auto id = SubmitBox(spec);
      const auto status = client->Watch(id, {});
      stop = true;
      thread.join();
      ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
      ExpectBits(*client, id, expected);
      EXPECT_GT(worker.shards, 0);
      if (c.what != std::string("is of no use")) {
        EXPECT_EQ(worker.refused, 0);
      }
    }
  }
}

TEST_F(Shards, WhatWorkersAnswerIsTaken) {
  // Or the test above shows nothing: trees of another width, from a worker that passes for one like the others.
  const auto spec = ManyTrees("dense");
  const auto expected = RenderHere(box, spec);
  const auto other = [](const ShardUnit& unit) {
    return AnswerTreeRequest(Resealed(unit.request, [](Bytes* content) {
      const float sigma = 1.5f;  // it stands first
      std::memcpy(content->data(), &sigma, sizeof sigma);
    }));
  };
  std::atomic<bool> stop{false};
  ShardWorker worker(server->address(), box, spec, other);
  std::jthread thread([&] { worker.Run(stop); });
  // Whether an answer comes in time is a race that a busy machine may decide against it, but not every time.
  EXPECT_TRUE(Eventually(seconds(60), [&] {
    const auto id = SubmitBox(spec);
    EXPECT_EQ(client->Watch(id, {}).phase, JobPhase::kDone);
    return client->GetReport(id).find(expected.report.state_hash.hex) == std::string::npos;
  }));
  stop = true;
  thread.join();
}

TEST_F(Shards, AWorkerThatWouldMakeOtherTreesIsNotAsked) {
  const auto spec = ManyTrees("dense");
  std::atomic<bool> stop{false};
  ShardWorker worker(server->address(), box, spec, {}, "another rounding");
  std::jthread thread([&] { worker.Run(stop); });
  const auto id = SubmitBox(spec);
  const auto status = client->Watch(id, {});
  stop = true;
  thread.join();
  EXPECT_EQ(status.phase, JobPhase::kDone) << status.error;
  EXPECT_EQ(worker.shards, 0);
}

TEST_F(Shards, WorkersAsTheyAreShareIn) {
  const auto spec = ManyTrees("dense");
  const auto expected = RenderHere(box, spec);
  Worker first(WorkerOptions(server->address())), second(WorkerOptions(server->address()));
  std::jthread threads[] = {std::jthread([&] { first.Run(); }), std::jthread([&] { second.Run(); })};
  const auto id = SubmitBox(spec);
  const auto status = client->Watch(id, {});
  first.Drain();
  second.Drain();
  for (auto& thread : threads) thread.join();
  ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
  ExpectBits(*client, id, expected);
  EXPECT_GT(first.shards() + second.shards(), 0u);
}

}  // namespace
}  // namespace lodestar
