#include "coordinator/job_store.h"

#include <boost/asio/post.hpp>
#include <future>

#include "coordinator/crash_point.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

constexpr const char* kColumns =
    "number, client_token, name, scene_path, priority, phase, submitted, description, reference, survey, fingerprint, "
    "checkpoint, image, guide, report, error, log, progress";

// An ended job keeps its description, its image and what it has learned.
constexpr const char* kUnneeded =
    "hash NOT IN (SELECT hash FROM needs) AND hash NOT IN (SELECT image FROM jobs) AND hash NOT IN (SELECT guide FROM "
    "jobs) AND hash NOT IN (SELECT checkpoint FROM jobs) AND hash NOT IN (SELECT description FROM jobs)";

constexpr const char* kSchema = R"(
  CREATE TABLE meta (key TEXT PRIMARY KEY, value INTEGER NOT NULL) STRICT;
  CREATE TABLE jobs (
    number INTEGER PRIMARY KEY AUTOINCREMENT, client_token TEXT NOT NULL UNIQUE, name TEXT NOT NULL, scene_path TEXT NOT NULL,
    priority INTEGER NOT NULL, phase INTEGER NOT NULL, submitted INTEGER NOT NULL, description TEXT NOT NULL, reference TEXT NOT NULL, survey BLOB NOT NULL,
    fingerprint TEXT NOT NULL, checkpoint TEXT NOT NULL, image TEXT NOT NULL, guide TEXT NOT NULL, report TEXT NOT NULL, error TEXT NOT NULL, log TEXT NOT NULL, progress BLOB NOT NULL) STRICT;
  CREATE TABLE blobs (hash TEXT PRIMARY KEY, size INTEGER NOT NULL, used INTEGER NOT NULL) STRICT;
  CREATE TABLE needs (job INTEGER NOT NULL REFERENCES jobs(number), hash TEXT NOT NULL REFERENCES blobs(hash), PRIMARY KEY (job, hash)) STRICT;
  CREATE INDEX needs_by_hash ON needs(hash);
)";

const std::filesystem::path& MadeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(ErrorKind::kIo, "the store folder " + folder.string() + " cannot be made: " + error.message());
  return folder;
}

}  // namespace

template <class F>
auto JobStore::Run(F&& f) -> decltype(f()) {
  std::packaged_task<decltype(f())()> task(std::forward<F>(f));
  auto result = task.get_future();
  boost::asio::post(thread_, [&task] { task(); });
  return result.get();
}

JobStore::JobStore(const std::filesystem::path& folder, std::function<void(const std::string&)> fenced)
    : lock_(MadeFolder(folder) / "lock", FileLock::Mode::kTry, "--store"), fenced_(std::move(fenced)) {
  if (!lock_.held()) {
    throw Error(ErrorKind::kConflict, "another coordinator of this machine holds the store " + folder.string() +
                                          ": stop it first, or take another --store");
  }
  Run([&] { Open(folder / "jobs.sqlite"); });
}

JobStore::~JobStore() = default;

void JobStore::Open(const std::filesystem::path& file) {
  database_ = std::make_unique<Database>(file);
  database_->Transaction([&] {
    Statement exists(*database_, "SELECT count(*) FROM sqlite_master WHERE name = 'meta'");
    exists.Step();
    if (exists.Integer(0) == 0) {
      database_->Execute(kSchema);
      Statement(*database_, "INSERT INTO meta VALUES ('schema', ?)").Bind(kSchemaVersion).Run();
      Statement(*database_, "INSERT INTO meta VALUES ('epoch', 0)").Run();
    }
    Statement schema(*database_, "SELECT value FROM meta WHERE key = 'schema'");
    const int64_t version = schema.Step() ? schema.Integer(0) : 0;
    if (version != kSchemaVersion) {
      throw Error(ErrorKind::kConflict, file.string() + " has schema version " + std::to_string(version) +
                                            ", this coordinator reads version " + std::to_string(kSchemaVersion) +
                                            ": start the release that wrote it, or take another --store");
    }
    Statement(*database_, "UPDATE meta SET value = value + 1 WHERE key = 'epoch'").Run();
    Statement epoch(*database_, "SELECT value FROM meta WHERE key = 'epoch'");
    epoch.Step();
    epoch_ = static_cast<uint64_t>(epoch.Integer(0));
  });
}

void JobStore::Write(const std::function<void()>& body) {
  database_->Transaction([&] {
    Statement epoch(*database_, "SELECT value FROM meta WHERE key = 'epoch'");
    epoch.Step();
    if (static_cast<uint64_t>(epoch.Integer(0)) != epoch_) {
      const std::string why = "another coordinator (epoch " + std::to_string(epoch.Integer(0)) +
                              ") has taken over this store from epoch " + std::to_string(epoch_) +
                              ": this one must end";
      if (fenced_) fenced_(why);
      throw Error(ErrorKind::kConflict, why);
    }
    body();
  });
}

StoredJob JobStore::ReadRow(Statement& row) {
  StoredJob job;
  job.number = row.Integer(0);
  job.client_token = row.Text(1);
  job.name = row.Text(2);
  job.scene_path = row.Text(3);
  job.priority = static_cast<int>(row.Integer(4));
  job.phase = static_cast<JobPhase>(row.Integer(5));
  job.submitted_unix_ms = row.Integer(6);
  job.description.hex = row.Text(7);
  job.reference.hex = row.Text(8);
  job.survey = row.Text(9);
  job.fingerprint = row.Text(10);
  job.checkpoint.hex = row.Text(11);
  job.image.hex = row.Text(12);
  job.guide.hex = row.Text(13);
  job.report = row.Text(14);
  job.error = row.Text(15);
  job.log = row.Text(16);
  job.progress = row.Text(17);
  return job;
}

StoredJob JobStore::Insert(const StoredJob& job, const std::vector<ContentHash>& assets) {
  return Run([&] {
    StoredJob stored = job;
    Write([&] {
      Statement same(*database_, std::string("SELECT ") + kColumns + " FROM jobs WHERE client_token = ?");
      same.Bind(job.client_token);
      if (same.Step()) {
        stored = ReadRow(same);
        return;
      }
      std::string missing;
      int count = 0;
      for (const auto& asset : assets) {
        Statement there(*database_, "SELECT 1 FROM blobs WHERE hash = ?");
        if (!there.Bind(asset.hex).Step() && ++count <= 3) missing += " " + asset.hex;
      }
      if (count > 0) {
        throw Error(ErrorKind::kConflict,
                    std::to_string(count) + " files of the job were not uploaded, or were collected since:" + missing +
                        (count > 3 ? " ..." : "") + "; upload them and submit again");
      }
      Statement insert(*database_, std::string("INSERT INTO jobs (") + kColumns +
                                       ") VALUES (NULL, ?, ?, ?, ?, ?, ?, ?, ?, x'', '', '', '', '', '', '', '', x'')");
      insert.Bind(job.client_token)
          .Bind(job.name)
          .Bind(job.scene_path)
          .Bind(job.priority)
          .Bind(static_cast<int64_t>(job.phase))
          .Bind(job.submitted_unix_ms)
          .Bind(job.description.hex)
          .Bind(job.reference.hex)
          .Run();
      stored.number = database_->LastRowId();
      for (const auto& asset : assets) {
        Statement(*database_, "INSERT OR IGNORE INTO needs VALUES (?, ?)").Bind(stored.number).Bind(asset.hex).Run();
      }
      CrashPoint("job-before-commit");
    });
    return stored;
  });
}

void JobStore::Update(const StoredJob& job) {
  Run([&] {
    Write([&] {
      Statement(
          *database_,
          "UPDATE jobs SET phase = ?, survey = ?, fingerprint = ?, checkpoint = ?, image = ?, guide = ?, report = "
          "?, error = ?, log = ?, progress = ? WHERE number = ?")
          .Bind(static_cast<int64_t>(job.phase))
          .BindBlob(job.survey)
          .Bind(job.fingerprint)
          .Bind(job.checkpoint.hex)
          .Bind(job.image.hex)
          .Bind(job.guide.hex)
          .Bind(job.report)
          .Bind(job.error)
          .Bind(job.log)
          .BindBlob(job.progress)
          .Bind(job.number)
          .Run();
      // Exactly one checkpoint and, at the end, nothing but the image and the guide are needed.
      if (Ended(job.phase)) Statement(*database_, "DELETE FROM needs WHERE job = ?").Bind(job.number).Run();
    });
  });
}

std::vector<StoredJob> JobStore::Jobs() {
  return Run([&] {
    std::vector<StoredJob> jobs;
    Statement rows(*database_, std::string("SELECT ") + kColumns + " FROM jobs ORDER BY number");
    while (rows.Step()) jobs.push_back(ReadRow(rows));
    return jobs;
  });
}

void JobStore::AddBlob(const ContentHash& hash, uint64_t size, int64_t now_unix_ms) {
  Run([&] {
    Write([&] {
      Statement(*database_, "INSERT INTO blobs VALUES (?, ?, ?) ON CONFLICT (hash) DO UPDATE SET used = excluded.used")
          .Bind(hash.hex)
          .Bind(static_cast<int64_t>(size))
          .Bind(now_unix_ms)
          .Run();
    });
  });
}

std::vector<ContentHash> JobStore::HaveBlobs(const std::vector<ContentHash>& hashes, int64_t now_unix_ms) {
  return Run([&] {
    std::vector<ContentHash> present;
    Write([&] {
      for (const auto& hash : hashes) {
        Statement there(*database_, "UPDATE blobs SET used = ? WHERE hash = ? RETURNING 1");
        const bool found = there.Bind(now_unix_ms).Bind(hash.hex).Step();
        if (found) {
          present.push_back(hash);
          there.Run();
        }
      }
    });
    return present;
  });
}

std::vector<ContentHash> JobStore::CollectBlobs(int64_t before_unix_ms) {
  return Run([&] {
    std::vector<ContentHash> gone;
    Write([&] {
      Statement rows(*database_, std::string("DELETE FROM blobs WHERE used < ? AND ") + kUnneeded + " RETURNING hash");
      rows.Bind(before_unix_ms);
      while (rows.Step()) gone.push_back({rows.Text(0)});
    });
    return gone;
  });
}

bool JobStore::DropBlob(const ContentHash& hash) {
  return Run([&] {
    bool gone = false;
    Write([&] {
      Statement row(*database_, std::string("DELETE FROM blobs WHERE hash = ? AND ") + kUnneeded + " RETURNING 1");
      gone = row.Bind(hash.hex).Step();
      if (gone) row.Run();
    });
    return gone;
  });
}

std::set<std::string> JobStore::AllBlobs() {
  return Run([&] {
    std::set<std::string> all;
    Statement rows(*database_, "SELECT hash FROM blobs");
    while (rows.Step()) all.insert(rows.Text(0));
    return all;
  });
}

}  // namespace lodestar
