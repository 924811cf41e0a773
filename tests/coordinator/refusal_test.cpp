// Jobs that cannot go on end with the reason. Where a coordinator takes no result the worker says so, and the job does
// not go round for ever; one that has too much at hand gets results later.
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "lodestar/v1/worker.grpc.pb.h"
#include "rpc/channel.h"
#include "rpc/status.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

constexpr const char* kReason = "the film of this contribution is of another size";

// Stands before a coordinator, hands on every call, and refuses so many contributions itself.
class RefusingFront final : public v1::Work::Service {
 public:
  RefusingFront(const std::string& coordinator, const grpc::Status& refusal, int times)
      : refusal_(refusal), left_(times), behind_(v1::Work::NewStub(OpenChannel(coordinator))) {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~RefusingFront() override { server_->Shutdown(std::chrono::system_clock::now()); }
  const std::string& address() const { return address_; }

  grpc::Status Register(grpc::ServerContext* c, const v1::RegisterRequest* q, v1::RegisterReply* r) override {
    return behind_->Register(Onward(c).get(), *q, r);
  }
  grpc::Status Lease(grpc::ServerContext* c, const v1::LeaseRequest* q, v1::LeaseReply* r) override {
    return behind_->Lease(Onward(c).get(), *q, r);
  }
  grpc::Status RenewLease(grpc::ServerContext* c, const v1::RenewLeaseRequest* q, v1::RenewLeaseReply* r) override {
    ++renewals_;
    return behind_->RenewLease(Onward(c).get(), *q, r);
  }
  grpc::Status SubmitSurvey(grpc::ServerContext* c, const v1::SubmitSurveyRequest* q,
                            v1::SubmitSurveyReply* r) override {
    return behind_->SubmitSurvey(Onward(c).get(), *q, r);
  }
  grpc::Status ReportFailure(grpc::ServerContext* c, const v1::ReportFailureRequest* q,
                             v1::ReportFailureReply* r) override {
    return behind_->ReportFailure(Onward(c).get(), *q, r);
  }
  grpc::Status FetchState(grpc::ServerContext* c, const v1::FetchStateRequest* q,
                          grpc::ServerWriter<v1::StateChunk>* out) override {
    const auto context = Onward(c);
    return HandOn(*behind_->FetchState(context.get(), *q), out);
  }
  grpc::Status FetchAsset(grpc::ServerContext* c, const v1::FetchAssetRequest* q,
                          grpc::ServerWriter<v1::AssetChunk>* out) override {
    const auto context = Onward(c);
    return HandOn(*behind_->FetchAsset(context.get(), *q), out);
  }
  grpc::Status SubmitContribution(grpc::ServerContext* c, grpc::ServerReader<v1::ContributionChunk>* in,
                                  v1::SubmitContributionReply* r) override {
    std::vector<v1::ContributionChunk> chunks;
    for (v1::ContributionChunk chunk; in->Read(&chunk);) chunks.push_back(chunk);
    if (left_.fetch_sub(1) > 0) {
      refused_ = true;
      return refusal_;
    }
    const auto context = Onward(c);
    const auto out = behind_->SubmitContribution(context.get(), r);
    for (const v1::ContributionChunk& chunk : chunks) out->Write(chunk);
    out->WritesDone();
    return out->Finish();
  }
  bool refused_any() const { return refused_; }
  bool refused_all() const { return left_ <= 0; }
  int renewals() const { return renewals_; }

 private:
  static std::unique_ptr<grpc::ClientContext> Onward(const grpc::ServerContext* from) {
    auto context = grpc::ClientContext::FromServerContext(*from);  // cancelled with it
    PrepareContext(context.get(), std::chrono::seconds(60));
    return context;
  }
  template <class Chunk>
  static grpc::Status HandOn(grpc::ClientReader<Chunk>& in, grpc::ServerWriter<Chunk>* out) {
    for (Chunk chunk; in.Read(&chunk);) out->Write(chunk);
    return in.Finish();
  }
  const grpc::Status refusal_;
  std::atomic<int> left_, renewals_ = 0;
  std::atomic<bool> refused_ = false;
  const std::unique_ptr<v1::Work::Stub> behind_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

struct Refusal : InProcessFarm {
  // One worker, until the job has ended; false where it does not in half a minute.
  bool WorkUntilItEnds(const JobId& id, const std::string& address) {
    Worker worker(WorkerOptions(address));
    std::thread thread([&] { worker.Run(); });
    const bool ended = Eventually(std::chrono::seconds(30), [&] { return Ended(client->GetJob(id).phase); });
    worker.Drain();
    thread.join();
    return ended;
  }
};

TEST_F(Refusal, AJobWhoseResultsAreRefusedEndsWithTheReason) {
  RefusingFront front(server->address(), ToStatus(Error(ErrorKind::kCorrupt, kReason)), 1000);
  const auto id = SubmitBox(BoxJob("path", 64));
  const bool ended = WorkUntilItEnds(id, front.address());
  ASSERT_TRUE(ended) << "leased and refused, again and again";
  const auto status = client->GetJob(id);
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  EXPECT_NE(status.error.find(kReason), std::string::npos) << status.error;
  EXPECT_EQ(std::count_if(status.log.begin(), status.log.end(),
                          [](const std::string& line) { return line.find(kReason) != std::string::npos; }),
            options.strikes + 1)
      << "one strike a delivery, however many leases it held, and the end: " << testing::PrintToString(status.log);
}

TEST_F(Refusal, AReferenceOfAnotherSizeEndsTheJobWithTheReason) {
  const Image small{2, 2, std::vector<Rgb>(4, Rgb(1)), std::vector<float>(4)};
  const auto id = SubmitBox(BoxJob("path", 8), client->UploadImage(small));
  const bool ended = WorkUntilItEnds(id, server->address());
  ASSERT_TRUE(ended);
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kFailed);
  EXPECT_NE(client->GetJob(id).error.find("the reference has another size"), std::string::npos)
      << client->GetJob(id).error;
}

TEST_F(Refusal, ACoordinatorWithTooMuchAtHandGetsResultsLater) {
  RefusingFront front(server->address(), ToStatus(ExhaustedError("too many calls are waiting")), options.strikes + 1);
  const auto id = SubmitBox(BoxJob("path", 64));
  const bool ended = WorkUntilItEnds(id, front.address());
  ASSERT_TRUE(ended);
  EXPECT_TRUE(front.refused_all());
  EXPECT_EQ(client->GetJob(id).phase, JobPhase::kDone) << client->GetJob(id).error;
}

TEST_F(Refusal, ARevokedLeaseIsNotAskedForAgain) {
  // What the worker cannot deliver it holds, though its job is over.
  RefusingFront front(server->address(), ToStatus(ExhaustedError("too many calls are waiting")), 1000);
  const auto id = SubmitBox(BoxJob("path", 64));
  Worker worker(WorkerOptions(front.address()));
  std::thread thread([&] { worker.Run(); });
  const bool refused = Eventually(std::chrono::seconds(30), [&] { return front.refused_any(); });
  client->Cancel(id);
  const bool ended = Eventually(std::chrono::seconds(10), [&] { return Ended(client->GetJob(id).phase); });
  const int before = front.renewals();
  std::this_thread::sleep_for(options.leases.duration / 2);
  const int renewals = front.renewals() - before;
  worker.Drain();
  thread.join();
  ASSERT_TRUE(refused && ended);
  EXPECT_LT(renewals, 20) << "each waits for a quarter of a lease's duration";
}

}  // namespace
}  // namespace lodestar
