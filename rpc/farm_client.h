// A client's view of a farm: plain values in and out, blocking calls with deadlines and retries inside.
//
// Every method throws Error: what the coordinator refused keeps its kind and message (kInvalidInput, kNotFound,
// kConflict, ...); a coordinator that cannot be reached after the retries is kIo, naming the address. Safe to use from
// several threads.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/stop.h"
#include "core/film/film.h"
#include "core/learning/guide_file.h"
#include "rpc/types.h"

namespace lodestar {

// A file on this machine and the name it has in the scene's own folder.
struct LocalFile {
  std::string name;
  std::filesystem::path path;
};
// The files of a scene (SceneDescription::files: the scene file first) under the folder they have in common. Throws
// Error(kNotFound) for a file that is not there.
struct SceneBundle {
  std::string main;
  std::vector<LocalFile> files;
};
SceneBundle BundleScene(const std::vector<std::string>& files);

struct UploadProgress {
  size_t files_done = 0, files = 0;  // of those that were missing at the coordinator
  uint64_t bytes_done = 0, bytes = 0;
};

class FarmClient {
 public:
  struct Options {
    double retry_seconds = 10;  // how long an unreachable coordinator is retried
    const Clock* clock = &Clock::Steady();
  };
  explicit FarmClient(const std::string& address, const Options& options);  // "host:port"
  explicit FarmClient(const std::string& address) : FarmClient(address, Options()) {}
  ~FarmClient();

  // Hashes the files, asks which are missing, uploads those, until none is; the manifest is what SubmitJob wants,
  // within the ten minutes that a coordinator keeps what no job needs. `progress` may be empty.
  SceneManifest Upload(const SceneBundle& bundle, const std::function<void(const UploadProgress&)>& progress = {});
  ContentHash UploadImage(const Image& image);  // where it is missing; for JobSubmission::reference
  JobId SubmitJob(JobSubmission submission);

  JobStatus GetJob(const JobId& id);
  std::vector<JobStatus> ListJobs();  // newest first
  // Calls back with every change until the job has ended or the callback returns false or `stop` is requested; survives
  // a coordinator's restart. Returns the last status.
  JobStatus Watch(const JobId& id, const std::function<bool(const JobStatus&)>& callback,
                  const StopToken* stop = nullptr);
  void Cancel(const JobId& id);
  Image GetImage(const JobId& id);         // kConflict: nothing rendered yet
  std::string GetReport(const JobId& id);  // JSON
  GuideFile GetGuide(const JobId& id);     // kConflict: nothing learned
  std::vector<WorkerStatus> Workers();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lodestar
