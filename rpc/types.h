// What the farm speaks about, as plain values: neither gRPC nor protobuf appears outside rpc/ and the handlers.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/hash.h"
#include "core/learning/job.h"

namespace lodestar {

// Both ends must speak the same; carried by every call.
inline constexpr uint32_t kProtocolVersion = 6;

// Sizes that a peer may ask for. Above them: INVALID_ARGUMENT or RESOURCE_EXHAUSTED, never an allocation.
inline constexpr size_t kMaxMessageBytes = size_t{4} << 20;
inline constexpr size_t kChunkBytes = size_t{512} << 10;  // of a stream, uncompressed; between 64 KiB and 1 MiB
inline constexpr size_t kMaxChunkBytes = size_t{1} << 20;
inline constexpr size_t kMaxShardBytes = size_t{3} << 20;
inline constexpr uint64_t kMaxAssetBytes = uint64_t{2} << 30;
inline constexpr uint64_t kMaxSceneBytes = uint64_t{16} << 30;
inline constexpr uint64_t kMaxContributionBytes = uint64_t{1} << 30;
inline constexpr uint64_t kMaxStateBytes = uint64_t{2} << 30;
inline constexpr size_t kMaxSceneFiles = 20000;

struct JobId {
  std::string value;  // "job-17"
  auto operator<=>(const JobId&) const = default;
};
struct WorkerId {
  std::string value;
  auto operator<=>(const WorkerId&) const = default;
};
struct LeaseId {
  uint64_t value = 0;  // 0: none
  auto operator<=>(const LeaseId&) const = default;
};

struct SceneFile {
  ContentHash hash;
  uint64_t size = 0;
  friend bool operator==(const SceneFile&, const SceneFile&) = default;
};
// A scene as files: names relative to a folder of its own, '/' between parts, no "." or "..".
struct SceneManifest {
  std::string main;  // one of the files
  std::map<std::string, SceneFile> files;

  // Throws Error(kInvalidInput) naming what is wrong: an unsafe name, a malformed hash, no main file, too many files,
  // too many bytes.
  void Validate() const;
  Bytes Serialize() const;
  static SceneManifest Parse(std::string_view bytes);
};

struct JobSubmission {
  std::string name;
  int priority = 0;  // larger first
  JobSpec spec;
  SceneManifest scene;
  uint32_t threads = 0;      // at most so many of each worker; 0: all that it has. Never changes the image.
  std::string scene_path;    // where the client has the scene file, for commands that a report tells it to run
  ContentHash reference;     // from FarmClient::UploadImage: error points are measured against it; empty: none
  std::string client_token;  // the same token never makes a second job; filled in by FarmClient where empty
};

enum class JobPhase { kQueued = 1, kRunning, kDone, kFailed, kCancelled };
const char* JobPhaseName(JobPhase phase);  // "queued", ...
inline bool Ended(JobPhase phase) {
  return phase >= JobPhase::kDone;
}

struct JobStatus {
  JobId id;
  std::string name;
  int priority = 0;
  std::string method;
  JobPhase phase = JobPhase::kQueued;
  std::string error;             // why it failed
  std::vector<std::string> log;  // last lines
  int64_t submitted_unix_ms = 0;
  JobProgress progress;
  uint32_t width = 0, height = 0;  // 0: not known yet
  std::string waiting_for;         // in words, for a job that is not rendering
  std::string scene_path;          // as submitted; not in lists
};

struct WorkerStatus {
  WorkerId id;
  std::string name;
  uint32_t threads = 0;
  std::string fingerprint;
  uint32_t leases = 0;
  uint64_t units = 0;
  double units_per_second = 0;
  double seconds_since_seen = 0;
};

}  // namespace lodestar
