// What a peer may get wrong: each a clear error, and the coordinator lives on with its queue intact.
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include "lodestar/v1/farm.grpc.pb.h"
#include "lodestar/v1/worker.grpc.pb.h"
#include "rpc/channel.h"
#include "rpc/convert.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

// Time stands still: nobody is given up for being slow.
struct BadInput : InProcessFarm {
  BadInput() : InProcessFarm(true) {}
  std::shared_ptr<grpc::Channel> channel = OpenChannel(server->address());
  std::unique_ptr<v1::Farm::Stub> farm_stub = v1::Farm::NewStub(channel);
  std::unique_ptr<v1::Work::Stub> work_stub = v1::Work::NewStub(channel);
  JobId queued;
  void SetUp() override { queued = SubmitBox(BoxJob("path", 4)); }
  void TearDown() override {
    // No worker is there: the job is still waiting, whatever was sent meanwhile.
    const auto jobs = client->ListJobs();
    ASSERT_EQ(jobs.size(), 1u);
    EXPECT_EQ(jobs[0].phase, JobPhase::kQueued);
    EXPECT_NE(jobs[0].waiting_for.find("worker"), std::string::npos);
  }
  template <class F>
  grpc::Status Call(F&& f) {
    grpc::ClientContext context;
    PrepareContext(&context, std::chrono::seconds(10));
    return f(&context);
  }
  v1::SubmitJobRequest Good() {
    JobSubmission submission;
    submission.name = "again";
    submission.spec = BoxJob("path", 4);
    submission.scene = client->Upload(box);
    submission.client_token = "token";
    v1::SubmitJobRequest request;
    *request.mutable_job() = ToProto(submission);
    return request;
  }
  grpc::Status Submit(const v1::SubmitJobRequest& request) {
    v1::SubmitJobReply reply;
    return Call([&](auto* context) { return farm_stub->SubmitJob(context, request, &reply); });
  }
};

void Expect(const grpc::Status& status, grpc::StatusCode code, const std::string& part) {
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  EXPECT_NE(status.error_message().find(part), std::string::npos) << status.error_message();
}

TEST_F(BadInput, UnknownMethodsAndOptionsAreListed) {
  auto request = Good();
  request.mutable_job()->mutable_spec()->set_method("magic");
  Expect(Submit(request), grpc::StatusCode::INVALID_ARGUMENT, "sdtree");
  request = Good();
  (*request.mutable_job()->mutable_spec()->mutable_options())["colour"] = "blue";
  Expect(Submit(request), grpc::StatusCode::INVALID_ARGUMENT, "colour");
}

TEST_F(BadInput, UnknownFieldsAreNamed) {
  auto request = Good();
  auto* job = request.mutable_job();
  job->GetReflection()->MutableUnknownFields(job)->AddVarint(999, 1);
  Expect(Submit(request), grpc::StatusCode::INVALID_ARGUMENT, "999");
}

TEST_F(BadInput, OversizedMessagesAreRefused) {
  auto request = Good();
  request.mutable_job()->set_name(std::string(5 << 20, 'x'));
  grpc::ChannelArguments arguments;
  arguments.SetMaxSendMessageSize(-1);
  auto wide =
      v1::Farm::NewStub(grpc::CreateCustomChannel(server->address(), grpc::InsecureChannelCredentials(), arguments));
  v1::SubmitJobReply reply;
  Expect(Call([&](auto* context) { return wide->SubmitJob(context, request, &reply); }),
         grpc::StatusCode::RESOURCE_EXHAUSTED, "larger than max");
  // And what the client itself would not send.
  EXPECT_EQ(Submit(request).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(BadInput, OtherProtocolVersionsAreTurnedAway) {
  for (const char* version : {"", "1", "999999999999999999999"}) {
    grpc::ClientContext context;
    if (*version) context.AddMetadata(kProtocolKey, version);
    v1::ListJobsReply reply;
    Expect(farm_stub->ListJobs(&context, {}, &reply), grpc::StatusCode::FAILED_PRECONDITION, "protocol");
  }
  v1::RegisterRequest request;
  request.set_protocol_version(kProtocolVersion - 1);
  v1::RegisterReply reply;
  Expect(Call([&](auto* context) { return work_stub->Register(context, request, &reply); }),
         grpc::StatusCode::FAILED_PRECONDITION, "install the same release");
  grpc::ClientContext context;
  context.AddMetadata(kProtocolKey, "1");
  v1::LeaseReply lease;
  Expect(work_stub->Lease(&context, {}, &lease), grpc::StatusCode::FAILED_PRECONDITION, "protocol");
}

TEST_F(BadInput, ScenesMustBeUploadedAndStayInside) {
  auto request = Good();
  request.mutable_job()->mutable_scene()->mutable_files(0)->set_sha256(std::string(64, '0'));
  Expect(Submit(request), grpc::StatusCode::FAILED_PRECONDITION, "not uploaded");
  request = Good();
  request.mutable_job()->set_reference_sha256(std::string(64, '0'));
  Expect(Submit(request), grpc::StatusCode::FAILED_PRECONDITION, "not uploaded");
  request = Good();
  auto* file = request.mutable_job()->mutable_scene()->add_files();
  file->set_name("../../etc/cron.d/x");
  file->set_sha256(std::string(64, '0'));
  Expect(Submit(request), grpc::StatusCode::INVALID_ARGUMENT, "..");
  request = Good();
  request.mutable_job()->clear_client_token();
  Expect(Submit(request), grpc::StatusCode::INVALID_ARGUMENT, "client_token");
}

TEST_F(BadInput, UploadsAreChecked) {
  const auto put = [&](std::vector<v1::AssetChunk> chunks) {
    return Call([&](auto* context) {
      v1::PutAssetReply reply;
      auto writer = farm_stub->PutAsset(context, &reply);
      for (const auto& chunk : chunks) writer->Write(chunk);
      writer->WritesDone();
      return writer->Finish();
    });
  };
  v1::AssetChunk chunk;
  chunk.set_sha256(Sha256("content").hex);
  chunk.set_size(7);
  chunk.set_data(Compress("c0ntent"));
  Expect(put({chunk}), grpc::StatusCode::DATA_LOSS, "damaged");
  chunk.set_data("this is not zstd");
  Expect(put({chunk}), grpc::StatusCode::DATA_LOSS, "chunk");
  chunk.set_data(Compress("content and more"));
  Expect(put({chunk}), grpc::StatusCode::INVALID_ARGUMENT, "longer");
  chunk.set_data(Compress(std::string(kMaxChunkBytes + 1, '\0')));  // a small bomb
  EXPECT_EQ(put({chunk}).error_code(), grpc::StatusCode::DATA_LOSS);
  chunk.set_size(kMaxAssetBytes + 1);
  Expect(put({chunk}), grpc::StatusCode::INVALID_ARGUMENT, "at most");
  chunk.set_size(uint64_t{1} << 30);
  chunk.set_sha256("../../x");
  Expect(put({chunk}), grpc::StatusCode::INVALID_ARGUMENT, "SHA-256");
  EXPECT_EQ(put({}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(BadInput, UnknownNamesAreNotFound) {
  for (const char* id : {"job-99", "job--1", "", "job-1x", "../../x"}) {
    v1::GetJobRequest request;
    request.set_job_id(id);
    v1::GetJobReply reply;
    Expect(Call([&](auto* context) { return farm_stub->GetJob(context, request, &reply); }),
           grpc::StatusCode::NOT_FOUND, "lodestar jobs");
    v1::WatchJobRequest watch;
    watch.set_job_id(id);
    Expect(Call([&](auto* context) {
             auto reader = farm_stub->WatchJob(context, watch);
             v1::JobStatus status;
             EXPECT_FALSE(reader->Read(&status));
             return reader->Finish();
           }),
           grpc::StatusCode::NOT_FOUND, "job");
  }
  WorkClient worker(server->address());
  EXPECT_THROW(worker.Lease({"nobody"}, std::chrono::seconds(1)), Error);
  EXPECT_THROW(worker.FetchState(Sha256("x")), Error);
  EXPECT_THROW(worker.FetchBytes(Sha256("x"), 100), Error);
  EXPECT_THROW(client->GetImage(queued), Error) << "nothing has been rendered";
  EXPECT_THROW(client->GetReport(queued), Error);
  EXPECT_THROW(client->GetGuide(queued), Error);
}

TEST_F(BadInput, ContributionsThatAreNoneAreRefused) {
  WorkClient worker(server->address());
  const ContributionHeader header{{"w"}, {{1}}, queued, {0, 0, 0, 1, 12, true}, {{0, 0}}, Sha256("s"), 0, 1};
  EXPECT_EQ(worker.SubmitContribution(header, "garbage"), ContributionOutcome::kStale) << "its job has no open round";
  // Half a stream, then gone.
  grpc::ClientContext context;
  PrepareContext(&context, std::chrono::seconds(10));
  v1::SubmitContributionReply reply;
  auto writer = work_stub->SubmitContribution(&context, &reply);
  v1::ContributionChunk chunk;
  *chunk.mutable_header() = ToProto(header);
  writer->Write(chunk);
  context.TryCancel();
  EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // No header at all.
  Expect(Call([&](auto* c) {
           auto w = work_stub->SubmitContribution(c, &reply);
           v1::ContributionChunk bare;
           bare.set_data("x");
           w->Write(bare);
           w->WritesDone();
           return w->Finish();
         }),
         grpc::StatusCode::INVALID_ARGUMENT, "header");
}

TEST_F(BadInput, WorkersThatHangUpLeaveNothingBehind) {
  for (int i = 0; i < 20; ++i) {
    WorkClient worker(server->address());
    WorkerInfo info;
    info.build_id = "x";
    const auto id = worker.Register(info).id;
    auto first = worker.Lease(id, std::chrono::seconds(5));  // the survey
    ASSERT_TRUE(first);
    worker.ReportFailure({UnitFailure::Kind::kReturned, id, first->id, first->job, ""});
  }
  // Another waits for more work when it goes: its call must not be answered with a lease that nobody holds.
  {
    WorkClient other(server->address());
    WorkerInfo info;
    info.build_id = "x";
    const auto id = other.Register(info).id;
    const auto first = other.Lease(id, std::chrono::seconds(5));
    ASSERT_TRUE(first);
    std::thread waiting([&] { EXPECT_THROW(other.Lease(id, std::chrono::seconds(30)), Error); });
    other.Shutdown();
    waiting.join();
  }
  EXPECT_EQ(client->Workers().size(), 21u);
  clock.Advance(options.leases.duration);  // of the one survey that was not given back
  EXPECT_TRUE(Eventually(std::chrono::seconds(10), [&] {
    uint32_t leases = 0;
    for (const auto& worker : client->Workers()) leases += worker.leases;
    return leases == 0;
  }));
}

}  // namespace
}  // namespace lodestar
