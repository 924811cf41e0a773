// What must survive the coordinator: jobs, and which blobs there are. SQLite, one connection, owned by one thread of
// this class; every method may be called from any thread and blocks until its transaction is on disk.
//
// A store has one coordinator: on this machine by a lock, taken before anything else. Across machines (a shared disk)
// by an epoch, which each coordinator raises that opens the store: a transaction of an older epoch is refused with
// Error(kConflict), so that a coordinator that was taken for dead cannot write beside its successor.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <memory>
#include <set>

#include "coordinator/sqlite.h"
#include "core/base/file_lock.h"
#include "rpc/work_types.h"

namespace lodestar {

struct StoredJob {
  int64_t number = 0;  // assigned by Insert
  std::string client_token, name, scene_path;
  int priority = 0;
  JobPhase phase = JobPhase::kQueued;
  int64_t submitted_unix_ms = 0;
  ContentHash description;        // blob: JobDescription
  ContentHash reference;          // blob: an image to measure against; empty: none
  Bytes survey;                   // empty: not surveyed yet
  std::string fingerprint;        // of the workers it runs on, from its survey on
  ContentHash checkpoint, image;  // blobs; empty: none
  ContentHash guide;              // blob, once it has ended: GuideFile; empty: nothing was learned
  std::string report, error, log;
  Bytes progress;  // JobProgress, for lists after a restart
  JobId id() const { return {"job-" + std::to_string(number)}; }
};

class JobStore {
 public:
  static constexpr int kSchemaVersion = 3;
  // `fenced` is called with the reason, on the owning thread, before a transaction is refused for its epoch. Throws
  // Error(kConflict) for a store that another holds or of another schema version, (kCorrupt), (kIo).
  explicit JobStore(const std::filesystem::path& folder, std::function<void(const std::string&)> fenced = {});
  ~JobStore();

  uint64_t epoch() const { return epoch_; }
  // Existing job with this client token, or the new one; `assets` must all be there, else Error(kConflict) naming the
  // first missing ones.
  StoredJob Insert(const StoredJob& job, const std::vector<ContentHash>& assets);
  void Update(const StoredJob& job);
  std::vector<StoredJob> Jobs();  // by number

  void AddBlob(const ContentHash& hash, uint64_t size, int64_t now_unix_ms);
  // Those that are there; they count as used at `now_unix_ms`.
  std::vector<ContentHash> HaveBlobs(const std::vector<ContentHash>& hashes, int64_t now_unix_ms);
  // Forgets blobs that no job needs and that nobody has asked for since `before_unix_ms`; the caller removes their
  // files.
  std::vector<ContentHash> CollectBlobs(int64_t before_unix_ms);
  // Forgets one blob where no job needs it; true if so.
  bool DropBlob(const ContentHash& hash);
  std::set<std::string> AllBlobs();

 private:
  void Open(const std::filesystem::path& file);
  void Write(const std::function<void()>& body);  // on the owning thread: a transaction that checks the epoch
  StoredJob ReadRow(Statement& row);
  template <class F>
  auto Run(F&& f) -> decltype(f());

  const FileLock lock_;  // a store has one coordinator on this machine
  const std::function<void(const std::string&)> fenced_;
  std::unique_ptr<Database> database_;
  uint64_t epoch_ = 0;
  boost::asio::thread_pool thread_{1};
};

}  // namespace lodestar
