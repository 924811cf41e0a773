// The farm and its handlers under many threads at once, without gRPC in between: what ThreadSanitizer sees of them is
// all there is to see (gRPC as packaged is not instrumented and hides or invents the order of things).
#include <atomic>
#include <condition_variable>
#include <fstream>
#include <random>
#include <thread>

#include "coordinator/handlers/farm_handlers.h"
#include "coordinator/handlers/work_handlers.h"
#include "core/guiding/tree_request.h"
#include "core/learning/contribution.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "rpc/convert.h"
#include "tests/farm/support/farm_fixture.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using std::chrono::seconds;

// An answer that comes now or later, from any thread.
template <class Reply>
class Mailbox {
 public:
  std::function<bool(const Reply&)> Answer() {
    return [this](const Reply& reply) {
      std::lock_guard lock(mutex_);
      reply_ = reply;
      come_.notify_all();
      return true;
    };
  }
  Reply Wait() {
    std::unique_lock lock(mutex_);
    come_.wait(lock, [&] { return reply_.has_value(); });
    return *std::exchange(reply_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::condition_variable come_;
  std::optional<Reply> reply_;
};

// A worker that speaks to the handlers, renews in a second thread, and delivers some results twice.
class DirectWorker {
 public:
  DirectWorker(Farm& farm, const SceneBundle& box, const JobSpec& spec, uint32_t seed)
      : farm_(farm),
        compiled_(CompileJob(ParsePbrtFile(box.files.front().path), spec)),
        method_(MakeMethod(spec, compiled_.survey)),
        executor_(compiled_.scene, spec, *method_, 1),
        random_(seed) {
    v1::RegisterRequest request;
    request.set_protocol_version(kProtocolVersion);
    request.set_build_id("direct");
    request.set_tree_canary(TreeCanary());
    v1::RegisterReply reply;
    Register(farm_, request, &reply);
    id_ = reply.worker_id();
  }
  void Run(const std::atomic<bool>& stop) {
    std::jthread renewing([&] {
      while (!stop) Renew();
    });
    while (!stop) {
      v1::LeaseRequest request;
      request.set_worker_id(id_);
      request.set_wait_ms(20);
      Mailbox<v1::LeaseReply> mailbox;
      Lease(farm_, request, mailbox.Answer());
      const auto reply = mailbox.Wait();
      if (!reply.has_lease()) continue;
      const auto unit = FromProto(reply.lease());
      unit.render ? Render(unit) : unit.shard ? MakeTrees(unit) : Survey(unit);
    }
  }
  int shards = 0;

 private:
  void Renew() {
    v1::RenewLeaseRequest request;
    request.set_worker_id(id_);
    request.set_wait_ms(20);
    {
      std::lock_guard lock(mutex_);
      request.add_lease_ids(held_);
    }
    Mailbox<v1::RenewLeaseReply> mailbox;
    RenewLease(farm_, request, mailbox.Answer());
    mailbox.Wait();
  }
  void Survey(const LeasedUnit& unit) {
    v1::SubmitSurveyReply reply;
    SubmitSurvey(farm_, ToProto(SurveyResult{{id_}, unit.id, unit.job, compiled_.survey.Serialize(), "", {}}), &reply);
  }
  void Hold(const LeasedUnit& unit) {
    std::lock_guard lock(mutex_);
    held_ = unit.id.value;
  }
  void MakeTrees(const LeasedUnit& unit) {
    Hold(unit);
    ++shards;
    if (random_() % 4 == 0) return;  // forgotten
    v1::SubmitShardReply reply;
    SubmitShard(farm_, ToProto(ShardAnswer{{id_}, unit.id, unit.job, AnswerTreeRequest(unit.shard->request)}), &reply);
  }
  void Render(const LeasedUnit& unit) {
    Hold(unit);
    const RenderUnit& r = *unit.render;
    try {
      Bytes state_bytes;
      v1::FetchStateRequest request;
      request.set_sha256(r.state.hex);
      v1::StateChunk chunk;
      for (auto next = FetchState(farm_, request); next(&chunk);) state_bytes += chunk.data();
      const auto state = method_->ParseState(state_bytes);
      Contribution contribution;
      executor_.ExecuteNode(state, r.round, r.node, StopToken(), &contribution);
      const Bytes bytes = SerializeContribution(contribution);
      for (int i = random_() % 4 == 0 ? 2 : 1; i > 0; --i) {
        v1::ContributionChunk part;
        *part.mutable_header() =
            ToProto(ContributionHeader{{id_}, {unit.id}, unit.job, r.round, {r.node}, r.state, bytes.size(), 0.001});
        part.set_data(bytes);
        SubmitContribution submit(farm_);
        submit.Add(part);
        v1::SubmitContributionReply reply;
        submit.Finish(&reply);
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kNotFound) << error.what();  // that state is over
    }
  }

  Farm& farm_;
  const CompiledJob compiled_;
  const std::unique_ptr<Method> method_;
  LocalExecutor executor_;
  std::mt19937 random_;
  std::string id_;
  std::mutex mutex_;
  uint64_t held_ = 0;
};

struct FarmThreads : testing::Test {
  TemporaryFolder folder;
  SceneBundle box = WriteBox(folder.path() / "scene");
  Farm::Options options;
  FarmThreads() {
    options.store = folder.path() / "store";
    options.blobs.reserve_bytes = 1 << 20;
    options.checkpoint_interval = options.checkpoint_least = std::chrono::milliseconds(5);
    options.leases.unknown_grace = options.leases.straggler_grace = std::chrono::milliseconds(20);
    options.alone_share = -1;  // every advance is offered
  }
  // What FarmClient does.
  std::string Submit(Farm& farm, const JobSpec& spec, const std::string& token) {
    JobSubmission submission;
    submission.name = token;
    submission.spec = spec;
    submission.client_token = token;
    submission.scene.main = box.main;
    for (const auto& file : box.files) {
      std::ifstream in(file.path);
      const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
      submission.scene.files[file.name] = {Sha256(bytes), bytes.size()};
      PutAsset put(farm);
      v1::AssetChunk chunk;
      chunk.set_sha256(Sha256(bytes).hex);
      chunk.set_size(bytes.size());
      chunk.set_data(Compress(bytes));
      put.Add(chunk);
      v1::PutAssetReply reply;
      put.Finish(&reply);
    }
    v1::SubmitJobRequest request;
    *request.mutable_job() = ToProto(submission);
    v1::SubmitJobReply reply;
    SubmitJob(farm, request, &reply);
    return reply.job_id();
  }
  static JobStatus Get(Farm& farm, const std::string& id) {
    v1::GetJobRequest request;
    request.set_job_id(id);
    v1::GetJobReply reply;
    GetJob(farm, request, &reply);
    return FromProto(reply.job());
  }
  // Everything a client may ask, at any time.
  static void Ask(Farm& farm, const std::string& id) {
    Get(farm, id);
    v1::ListJobsReply jobs;
    ListJobs(farm, {}, &jobs);
    v1::ListWorkersReply workers;
    ListWorkers(farm, {}, &workers);
    const auto seen = std::make_shared<std::atomic<int>>(0);  // a call may still be under way when it is unwatched
    v1::WatchJobRequest watch;
    watch.set_job_id(id);
    const auto number = WatchJob(farm, watch, [seen](const v1::JobStatus&) { ++*seen; });
    try {
      v1::GetReportRequest report;
      report.set_job_id(id);
      v1::GetReportReply reply;
      GetReport(farm, report, &reply);
      v1::GetImageRequest image;
      image.set_job_id(id);
      v1::ImageChunk chunk;
      for (auto next = GetImage(farm, image); next(&chunk);) {
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kConflict) << error.what();  // nothing rendered yet
    }
    farm.Unwatch(number);
    EXPECT_GE(*seen, 1);
  }
};

TEST_F(FarmThreads, ClientsAndWorkersAtOnce) {
  auto spec = BoxJob("sdtree", 32);
  spec.options = {{"spatial-threshold", "100"},
                  {"flux-threshold", "0.001"},
                  {"reconstruction", "dense"}};  // several shards an advance
  spec.resolution_x = 80;
  spec.resolution_y = 60;
  const auto expected = RenderHere(box, spec);
  Farm farm(options);
  std::atomic<bool> stop{false};
  std::vector<std::unique_ptr<DirectWorker>> workers;
  std::vector<std::jthread> threads;
  for (uint32_t i = 0; i < 3; ++i) {
    workers.push_back(std::make_unique<DirectWorker>(farm, box, spec, i));
    threads.emplace_back([&, i] { workers[i]->Run(stop); });
  }
  const auto id = Submit(farm, spec, "kept"), other = Submit(farm, spec, "cancelled");
  for (int i = 0; i < 2; ++i) {
    threads.emplace_back([&] {
      while (!stop) Ask(farm, id), Ask(farm, other);
    });
  }
  EXPECT_TRUE(Eventually(seconds(60), [&] { return Get(farm, other).progress.passes > 0; }));
  v1::CancelJobRequest cancel;
  cancel.set_job_id(other);
  v1::CancelJobReply cancelled;
  CancelJob(farm, cancel, &cancelled);
  EXPECT_TRUE(Eventually(seconds(120), [&] { return Ended(Get(farm, id).phase) && Ended(Get(farm, other).phase); }));
  stop = true;
  threads.clear();
  EXPECT_EQ(Get(farm, id).phase, JobPhase::kDone) << Get(farm, id).error;
  EXPECT_TRUE(SameBits(*farm.GetImage({id}), expected.image));
  int shards = 0;
  for (const auto& worker : workers) shards += worker->shards;
  EXPECT_GT(shards, 0);
}

// The farm may end at any moment while others call it; what it has stored is enough.
TEST_F(FarmThreads, EndsWhileItIsAsked) {
  const auto spec = BoxJob("sdtree", 32);
  std::string id;
  for (int run = 0; run < 3; ++run) {
    auto farm = std::make_unique<Farm>(options);
    std::atomic<bool> stop{false};
    DirectWorker worker(*farm, box, spec, 7);
    std::jthread working([&] { worker.Run(stop); });
    if (run == 0) id = Submit(*farm, spec, "job");
    const uint64_t before = Get(*farm, id).progress.passes;
    EXPECT_TRUE(Eventually(seconds(60), [&] {
      const auto status = Get(*farm, id);
      return Ended(status.phase) || (run < 2 && status.progress.passes > before + 2);
    }));
    stop = true;
    working.join();
    if (run == 2) {
      EXPECT_TRUE(SameBits(*farm->GetImage({id}), RenderHere(box, spec).image));
    }
  }
}

}  // namespace
}  // namespace lodestar
