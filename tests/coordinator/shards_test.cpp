// Advances that workers share in: nobody sees from the result who made which tree.
#include <cstring>
#include <thread>

#include "core/guiding/tree_request.h"
#include "tests/coordinator/hand_worker.h"
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

// Does what it is told, but with shards whatever `answer` makes of them.
class ShardWorker {
 public:
  using Answer = std::function<std::optional<Bytes>(const ShardUnit&)>;
  ShardWorker(const std::string& address, const SceneBundle& box, const JobSpec& spec, Answer answer,
              const std::string& tree_canary = TreeCanary())
      : hand_(address, box, spec, "shards", "", tree_canary), answer_(std::move(answer)) {}
  void Run(const std::atomic<bool>& stop) {
    while (!stop) {
      const auto unit = hand_.Lease(milliseconds(100));
      if (!unit) continue;
      try {
        if (unit->render) {
          hand_.Render(*unit);
        } else if (unit->shard) {
          ++shards;
          if (const auto trees = answer_(*unit->shard)) hand_.Answer(*unit, *trees);
        } else {
          hand_.Survey(*unit);
        }
      } catch (const Error& error) {
        if (!unit->shard) {
          EXPECT_EQ(error.kind(), ErrorKind::kNotFound) << error.what();  // that state is over
          continue;
        }
        EXPECT_EQ(error.kind(), ErrorKind::kCorrupt) << error.what();
        ++refused;
      }
    }
  }
  int shards = 0, refused = 0;

 private:
  HandWorker hand_;
  const Answer answer_;
};

struct Shards : InProcessFarm {
  Shards() {
    End();
    options.alone_share = -1;  // every advance is offered, from its first shard on
    Start();
  }
  // Jobs as `submit` hands them in, with this worker alone.
  template <class Submit>
  void With(ShardWorker& worker, const Submit& submit) {
    std::atomic<bool> stop{false};
    std::jthread thread([&] { worker.Run(stop); });
    submit();
    stop = true;
  }
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
      ShardWorker worker(server->address(), box, spec, c.answer);
      With(worker, [&] {
        const auto id = SubmitBox(spec);
        const auto status = client->Watch(id, {});
        ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
        ExpectBits(*client, id, expected);
      });
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
  ShardWorker worker(server->address(), box, spec, other);
  With(worker, [&] {
    // Whether an answer comes in time is a race that a busy machine may decide against it, but not every time.
    EXPECT_TRUE(Eventually(seconds(60), [&] {
      const auto id = SubmitBox(spec);
      EXPECT_EQ(client->Watch(id, {}).phase, JobPhase::kDone);
      return client->GetReport(id).find(expected.report.state_hash.hex) == std::string::npos;
    }));
  });
}

TEST_F(Shards, AWorkerThatWouldMakeOtherTreesIsNotAsked) {
  const auto spec = ManyTrees("dense");
  ShardWorker worker(server->address(), box, spec, {}, "another rounding");
  With(worker, [&] {
    const auto status = client->Watch(SubmitBox(spec), {});
    EXPECT_EQ(status.phase, JobPhase::kDone) << status.error;
  });
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
