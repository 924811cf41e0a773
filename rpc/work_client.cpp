#include "rpc/work_client.h"

#include <fstream>
#include <mutex>
#include <set>

#include "core/base/sha256_stream.h"
#include "lodestar/v1/worker.grpc.pb.h"
#include "rpc/channel.h"
#include "rpc/convert.h"
#include "rpc/streams.h"

namespace lodestar {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

struct WorkClient::Impl {
  std::string peer;
  std::unique_ptr<v1::Work::Stub> stub;
  std::mutex mutex;
  std::set<grpc::ClientContext*> calls;
  bool shut_down = false;

  void Call(Clock::Duration deadline, const std::function<grpc::Status(grpc::ClientContext*)>& call) {
    grpc::ClientContext context;
    PrepareContext(&context, deadline);
    {
      std::lock_guard lock(mutex);
      if (shut_down) throw UnreachableError("this worker is ending");
      calls.insert(&context);
    }
    struct Leave {
      Impl* impl;
      grpc::ClientContext* context;
      ~Leave() {
        std::lock_guard lock(impl->mutex);
        impl->calls.erase(context);
      }
    } leave{this, &context};
    ThrowIfFailed(call(&context), peer);
  }

  // Ends a stream that has sent more than it may.
  template <class Reader>
  [[noreturn]] static void Refuse(grpc::ClientContext* context, Reader& reader, const std::string& what,
                                  uint64_t max_size) {
    context->TryCancel();
    (void)reader.Finish();
    throw Error(ErrorKind::kCorrupt, what + " is larger than " + std::to_string(max_size) + " bytes");
  }

  // Hands each uncompressed chunk to `sink`.
  void ReadAsset(const ContentHash& hash, uint64_t max_size, const std::function<void(std::string_view)>& sink) {
    Sha256Stream sha;
    uint64_t total = 0;
    Call(minutes(60), [&](grpc::ClientContext* context) {
      v1::FetchAssetRequest request;
      request.set_sha256(hash.hex);
      auto reader = stub->FetchAsset(context, request);
      v1::AssetChunk chunk;
      while (reader->Read(&chunk)) {
        const Bytes part = Decompress(chunk.data(), "chunk of asset " + hash.hex, kMaxChunkBytes);
        total += part.size();
        if (total > max_size) Refuse(context, *reader, "asset " + hash.hex, max_size);
        sha.Add(part);
        sink(part);
      }
      return reader->Finish();
    });
    if (sha.Finish() != hash)
      throw Error(ErrorKind::kCorrupt, "asset " + hash.hex + " came with other content than its name");
  }
};

WorkClient::WorkClient(const std::string& address) : impl_(new Impl) {
  impl_->peer = "the coordinator at " + address;
  impl_->stub = v1::Work::NewStub(OpenChannel(address));
}
WorkClient::~WorkClient() = default;

void WorkClient::Shutdown() {
  std::lock_guard lock(impl_->mutex);
  impl_->shut_down = true;
  for (auto* context : impl_->calls) context->TryCancel();
}

Registration WorkClient::Register(const WorkerInfo& info) {
  v1::RegisterReply reply;
  const auto request = ToProto(info);
  impl_->Call(seconds(10),
              [&](grpc::ClientContext* context) { return impl_->stub->Register(context, request, &reply); });
  return {{reply.worker_id()}, reply.epoch(), milliseconds(reply.lease_ms())};
}

std::optional<LeasedUnit> WorkClient::Lease(const WorkerId& worker, Clock::Duration wait) {
  v1::LeaseRequest request;
  request.set_worker_id(worker.value);
  request.set_wait_ms(static_cast<uint32_t>(wait / milliseconds(1)));
  v1::LeaseReply reply;
  impl_->Call(wait + seconds(10),
              [&](grpc::ClientContext* context) { return impl_->stub->Lease(context, request, &reply); });
  if (!reply.has_lease()) return std::nullopt;
  return FromProto(reply.lease());
}

std::vector<LeaseId> WorkClient::RenewLease(const WorkerId& worker, const std::vector<LeaseId>& leases,
                                            Clock::Duration wait) {
  v1::RenewLeaseRequest request;
  request.set_worker_id(worker.value);
  for (const auto lease : leases) request.add_lease_ids(lease.value);
  request.set_wait_ms(static_cast<uint32_t>(wait / milliseconds(1)));
  v1::RenewLeaseReply reply;
  impl_->Call(wait + seconds(10),
              [&](grpc::ClientContext* context) { return impl_->stub->RenewLease(context, request, &reply); });
  std::vector<LeaseId> revoked;
  for (const auto id : reply.revoked()) revoked.push_back({id});
  return revoked;
}

Bytes WorkClient::FetchState(const ContentHash& hash) {
  Bytes bytes;
  impl_->Call(minutes(5), [&](grpc::ClientContext* context) {
    v1::FetchStateRequest request;
    request.set_sha256(hash.hex);
    auto reader = impl_->stub->FetchState(context, request);
    v1::StateChunk chunk;
    bytes.clear();
    while (reader->Read(&chunk)) {
      bytes += chunk.data();
      if (bytes.size() > kMaxStateBytes) Impl::Refuse(context, *reader, "state " + hash.hex, kMaxStateBytes);
    }
    return reader->Finish();
  });
  if (Sha256(bytes) != hash)
    throw Error(ErrorKind::kCorrupt, "state " + hash.hex + " came with other content than its name");
  return bytes;
}

Bytes WorkClient::FetchBytes(const ContentHash& hash, uint64_t max_size) {
  Bytes bytes;
  impl_->ReadAsset(hash, max_size, [&](std::string_view part) { bytes += part; });
  return bytes;
}

void WorkClient::FetchAsset(const ContentHash& hash, const std::filesystem::path& file) {
  try {
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    impl_->ReadAsset(hash, kMaxAssetBytes,
                     [&](std::string_view part) { out.write(part.data(), static_cast<std::streamsize>(part.size())); });
    out.close();
    if (!out) throw Error(ErrorKind::kIo, file.string() + " cannot be written: is the disk full?");
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    throw;
  }
}

ContributionOutcome WorkClient::SubmitContribution(ContributionHeader header, std::string_view bytes) {
  header.size = bytes.size();
  v1::SubmitContributionReply reply;
  impl_->Call(minutes(5), [&](grpc::ClientContext* context) {
    auto writer = impl_->stub->SubmitContribution(context, &reply);
    v1::ContributionChunk chunk;
    *chunk.mutable_header() = ToProto(header);
    ForEachChunk(bytes, [&](std::string_view part) {
      chunk.set_data(part.data(), part.size());
      const bool written = writer->Write(chunk);
      chunk.Clear();
      return written;
    });
    writer->WritesDone();
    return writer->Finish();
  });
  return static_cast<ContributionOutcome>(reply.outcome());
}

void WorkClient::SubmitSurvey(const SurveyResult& result) {
  const auto request = ToProto(result);
  v1::SubmitSurveyReply reply;
  impl_->Call(seconds(10),
              [&](grpc::ClientContext* context) { return impl_->stub->SubmitSurvey(context, request, &reply); });
}

void WorkClient::SubmitShard(const ShardAnswer& answer) {
  const auto request = ToProto(answer);
  v1::SubmitShardReply reply;
  impl_->Call(minutes(1),
              [&](grpc::ClientContext* context) { return impl_->stub->SubmitShard(context, request, &reply); });
}

void WorkClient::ReportFailure(const UnitFailure& failure) {
  const auto request = ToProto(failure);
  v1::ReportFailureReply reply;
  impl_->Call(seconds(10),
              [&](grpc::ClientContext* context) { return impl_->stub->ReportFailure(context, request, &reply); });
}

}  // namespace lodestar
