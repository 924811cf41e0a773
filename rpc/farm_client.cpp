#include "rpc/farm_client.h"

#include <algorithm>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "core/base/bytes.h"
#include "core/base/sha256_stream.h"
#include "lodestar/v1/farm.grpc.pb.h"
#include "rpc/channel.h"
#include "rpc/convert.h"
#include "rpc/image_bytes.h"
#include "rpc/retry.h"
#include "rpc/streams.h"

namespace lodestar {

using std::chrono::minutes;
using std::chrono::seconds;

struct FarmClient::Impl {
  std::string address;
  Options options;
  std::unique_ptr<v1::Farm::Stub> stub;

  // Repeats an idempotent call until it is answered, the time is over or `stop` (may be null) is requested.
  void Call(const std::function<grpc::Status(grpc::ClientContext*)>& call, Clock::Duration deadline = seconds(10),
            const StopToken* stop = nullptr) const {
    const Clock::Duration limit(static_cast<int64_t>(options.retry_seconds * 1e9));
    Retry(Idempotency::kIdempotent, limit, *options.clock, Sleeper::Real(), Backoff(), stop, [&] {
      grpc::ClientContext context;
      PrepareContext(&context, deadline);
      ThrowIfFailed(call(&context), "the coordinator at " + address);
    });
  }

  // Those of the hashes that the coordinator has not.
  std::set<std::string> Missing(const std::vector<std::string>& hashes) const {
    std::set<std::string> missing(hashes.begin(), hashes.end());
    for (size_t at = 0; at < hashes.size(); at += 4096) {
      v1::HasAssetsRequest request;
      for (size_t i = at; i < std::min(hashes.size(), at + 4096); ++i) request.add_sha256(hashes[i]);
      v1::HasAssetsReply reply;
      Call([&](grpc::ClientContext* context) { return stub->HasAssets(context, request, &reply); });
      for (const auto& hash : reply.present()) missing.erase(hash);
    }
    return missing;
  }

  void Put(std::istream& in, const SceneFile& entry, const std::function<void(uint64_t)>& sent) const {
    Call(
        [&](grpc::ClientContext* context) {
          v1::PutAssetReply reply;
          auto writer = stub->PutAsset(context, &reply);
          in.clear();
          in.seekg(0);
          v1::AssetChunk chunk;
          chunk.set_sha256(entry.hash.hex);
          chunk.set_size(entry.size);
          Bytes buffer(kChunkBytes, '\0');
          uint64_t total = 0;
          do {
            in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
            const auto count = static_cast<size_t>(in.gcount());
            chunk.set_data(Compress({buffer.data(), count}));
            if (!writer->Write(chunk)) break;  // Finish says why
            chunk.Clear();
            total += count;
            sent(total);
          } while (in);
          writer->WritesDone();
          return writer->Finish();
        },
        minutes(60));
  }
};

FarmClient::FarmClient(const std::string& address, const Options& options)
    : impl_(new Impl{address, options, v1::Farm::NewStub(OpenChannel(address))}) {}
FarmClient::~FarmClient() = default;

SceneManifest FarmClient::Upload(const SceneBundle& bundle,
                                 const std::function<void(const UploadProgress&)>& progress) {
  // Step 1: hash.
  SceneManifest manifest;
  manifest.main = bundle.main;
  std::map<std::string, const LocalFile*> by_hash;
  for (const auto& file : bundle.files) {
    SceneFile entry;
    entry.hash = Sha256OfFile(file.path, &entry.size);
    by_hash.emplace(entry.hash.hex, &file);
    manifest.files.emplace(file.name, std::move(entry));
  }
  manifest.Validate();
  // Step 2: what is there already?
  std::vector<std::string> asked;
  for (const auto& [hash, file] : by_hash) asked.push_back(hash);
  auto asked_at = impl_->options.clock->Now();
  std::set<std::string> missing = impl_->Missing(asked);
  // Step 3: upload the rest. Asking keeps what is there, and a large scene is longer on its way than a coordinator
  // keeps what nobody asks for.
  const auto keep = [&] {
    if (impl_->options.clock->Now() - asked_at < minutes(1)) return;
    asked_at = impl_->options.clock->Now();
    try {
      (void)impl_->Missing(asked);
    } catch (const Error&) {
      // The upload under way meets the same; what is lost by it is found missing at the end.
    }
  };
  UploadProgress state;
  for (; !missing.empty(); missing = impl_->Missing(asked)) {
    state.files += missing.size();
    for (const auto& hash : missing) state.bytes += manifest.files.at(by_hash.at(hash)->name).size;
    for (const auto& hash : missing) {
      const auto& file = *by_hash.at(hash);
      const auto& entry = manifest.files.at(file.name);
      const uint64_t before = state.bytes_done;
      std::ifstream in(file.path, std::ios::binary);
      if (!in) throw Error(ErrorKind::kNotFound, file.path.string() + " cannot be opened");
      impl_->Put(in, entry, [&](uint64_t sent) {
        state.bytes_done = before + sent;
        if (progress) progress(state);
        keep();
      });
      ++state.files_done;
      if (progress) progress(state);
    }
  }
  return manifest;
}

ContentHash FarmClient::UploadImage(const Image& image) {
  const Bytes bytes = ImageToBytes(image);
  const ContentHash hash = Sha256(bytes);
  std::istringstream in(bytes);
  if (!impl_->Missing({hash.hex}).empty()) impl_->Put(in, {hash, bytes.size()}, [](uint64_t) {});
  return hash;
}

JobId FarmClient::SubmitJob(JobSubmission submission) {
  if (submission.client_token.empty()) {
    std::random_device random;
    for (int i = 0; i < 4; ++i) submission.client_token += std::to_string(random()) + (i < 3 ? "-" : "");
  }
  v1::SubmitJobRequest request;
  *request.mutable_job() = ToProto(submission);
  v1::SubmitJobReply reply;
  impl_->Call([&](grpc::ClientContext* context) { return impl_->stub->SubmitJob(context, request, &reply); });
  return {reply.job_id()};
}

JobStatus FarmClient::GetJob(const JobId& id) {
  v1::GetJobRequest request;
  request.set_job_id(id.value);
  v1::GetJobReply reply;
  impl_->Call([&](grpc::ClientContext* context) { return impl_->stub->GetJob(context, request, &reply); });
  return FromProto(reply.job());
}

std::vector<JobStatus> FarmClient::ListJobs() {
  v1::ListJobsReply reply;
  impl_->Call([&](grpc::ClientContext* context) { return impl_->stub->ListJobs(context, {}, &reply); });
  std::vector<JobStatus> jobs;
  for (const auto& job : reply.jobs()) jobs.push_back(FromProto(job));
  return jobs;
}

JobStatus FarmClient::Watch(const JobId& id, const std::function<bool(const JobStatus&)>& callback,
                            const StopToken* stop) {
  v1::WatchJobRequest request;
  request.set_job_id(id.value);
  JobStatus last;
  last.id = id;
  bool more = true;
  const auto stopped = [&] { return stop && stop->Requested(); };
  const auto read = [&](grpc::ClientContext* context) {
    auto reader = impl_->stub->WatchJob(context, request);
    // Nothing may change for hours, and so long reading lasts.
    const std::jthread canceller([&](const std::stop_token& over) {
      while (!over.stop_requested() && !stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
      if (stopped()) context->TryCancel();
    });
    v1::JobStatus message;
    bool any = false;
    while (more && reader->Read(&message)) {
      any = true;
      last = FromProto(message);
      more = !callback || callback(last);
    }
    more = more && !stopped();
    if (!more) context->TryCancel();
    const auto status = reader->Finish();
    return any || !more ? grpc::Status::OK : status;
  };
  // A stream may end with its coordinator: each one that brought something starts the patience anew.
  while (more && !Ended(last.phase)) {
    try {
      impl_->Call(read, Clock::Duration(0), stop);
    } catch (const Error&) {
      // Whoever has stopped waits for nothing any more, the coordinator included.
      if (!stopped()) throw;
      more = false;
    }
  }
  return last;
}

void FarmClient::Cancel(const JobId& id) {
  v1::CancelJobRequest request;
  request.set_job_id(id.value);
  v1::CancelJobReply reply;
  impl_->Call([&](grpc::ClientContext* context) { return impl_->stub->CancelJob(context, request, &reply); });
}

Image FarmClient::GetImage(const JobId& id) {
  v1::GetImageRequest request;
  request.set_job_id(id.value);
  Bytes data;
  impl_->Call(
      [&](grpc::ClientContext* context) {
        data.clear();
        auto reader = impl_->stub->GetImage(context, request);
        v1::ImageChunk chunk;
        while (reader->Read(&chunk)) data += chunk.data();
        return reader->Finish();
      },
      minutes(60));
  return ImageFromBytes(data);
}

std::string FarmClient::GetReport(const JobId& id) {
  v1::GetReportRequest request;
  request.set_job_id(id.value);
  v1::GetReportReply reply;
  impl_->Call([&](grpc::ClientContext* context) { return impl_->stub->GetReport(context, request, &reply); });
  return reply.json();
}

GuideFile FarmClient::GetGuide(const JobId& id) {
  v1::GetGuideRequest request;
  request.set_job_id(id.value);
  Bytes data;
  impl_->Call(
      [&](grpc::ClientContext* context) {
        data.clear();
        auto reader = impl_->stub->GetGuide(context, request);
        v1::GuideChunk chunk;
        while (reader->Read(&chunk)) data += chunk.data();
        return reader->Finish();
      },
      minutes(60));
  return GuideFile::Parse(data, "what " + id.value + " has learned");
}

std::vector<WorkerStatus> FarmClient::Workers() {
  v1::ListWorkersReply reply;
  impl_->Call([&](grpc::ClientContext* context) { return impl_->stub->ListWorkers(context, {}, &reply); });
  std::vector<WorkerStatus> workers;
  for (const auto& worker : reply.workers()) workers.push_back(FromProto(worker));
  return workers;
}

}  // namespace lodestar
