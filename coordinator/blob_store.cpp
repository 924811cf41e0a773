#include "coordinator/blob_store.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "coordinator/crash_point.h"
#include "core/base/check.h"
#include "core/base/log.h"
#include "core/base/sha256_stream.h"
#include "rpc/status.h"

namespace lodestar {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void Fail(const fs::path& path, const char* doing) {
  const int code = errno;
  const std::string text = path.string() + " could not be " + doing + ": " + std::strerror(code);
  if (code == ENOSPC || code == EDQUOT) throw ExhaustedError(text + "; free some space on the store's disk");
  throw Error(ErrorKind::kIo, text);
}

// What a purpose leaves of the reserve.
struct Claim {
  uint64_t quarters;
  const char *kept_for, *then;
};
Claim ClaimOf(BlobStore::For purpose) {
  switch (purpose) {
    case BlobStore::For::kClient:
      return {4, "running jobs need", " and submit again"};
    case BlobStore::For::kCheckpoint:
      return {2, "results need", ""};
    case BlobStore::For::kResult:
      return {1, "the table of jobs needs", ""};
  }
  LODESTAR_CHECK(false);
}

void SyncFolder(const fs::path& folder) {
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) Fail(folder, "opened");
  const int result = fsync(fd);
  close(fd);
  if (result != 0) Fail(folder, "synchronised");
}

}  // namespace

struct BlobStore::Writer::Impl {
  BlobStore* store;
  ContentHash hash;
  uint64_t size, written = 0;
  fs::path temporary;
  int fd = -1;
  Sha256Stream sha;
  uint64_t promised = 0;  // its part of the store's
  void Keep(uint64_t bytes) {
    promised -= bytes;
    store->promised_ -= bytes;
  }
  ~Impl() {
    Keep(promised);
    if (fd >= 0) close(fd);
    std::error_code ignored;
    if (!temporary.empty()) fs::remove(temporary, ignored);
  }
};

BlobStore::Writer::Writer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BlobStore::Writer::~Writer() = default;

BlobStore::BlobStore(const fs::path& folder, JobStore& store, Options options)
    : folder_(folder), store_(store), options_(std::move(options)) {
  fs::create_directories(folder_ / "temporary");
  for (const auto& entry : fs::directory_iterator(folder_ / "temporary")) fs::remove(entry.path());
  const auto known = store_.AllBlobs();
  size_t orphans = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    if (!entry.is_regular_file() || known.contains(entry.path().filename().string())) continue;
    fs::remove(entry.path());
    ++orphans;
  }
  if (orphans > 0) spdlog::info("removed {} files that a crash had left without a row", orphans);
}

fs::path BlobStore::FileOf(const ContentHash& hash) const {
  if (!IsContentHash(hash.hex))
    throw Error(ErrorKind::kInvalidInput,
                "'" + hash.hex.substr(0, 80) + "' is not a SHA-256 of 64 lower-case hex digits");
  return folder_ / hash.hex.substr(0, 2) / hash.hex;
}

int64_t BlobStore::Now() const {
  if (options_.now_unix_ms) return options_.now_unix_ms();
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void BlobStore::CheckSpace(uint64_t bytes, For purpose, uint64_t promised) const {
  uint64_t available = 0;
  if (options_.free_bytes) {
    available = options_.free_bytes();
  } else {
    struct statvfs status;
    if (statvfs(folder_.c_str(), &status) != 0) Fail(folder_, "asked for its free space");
    available = uint64_t{status.f_bavail} * status.f_frsize;
  }
  const Claim claim = ClaimOf(purpose);
  const uint64_t kept = options_.reserve_bytes / 4 * claim.quarters;
  const uint64_t taken = kept + promised;
  if (available < taken || available - taken < bytes) {
    throw ExhaustedError(
        "the coordinator's disk is nearly full: " + std::to_string(bytes >> 20) +
        " MiB more would leave less than the " + std::to_string(kept >> 20) + " MiB that " + claim.kept_for + " (" +
        std::to_string(available >> 20) + " MiB are free in " + folder_.string() +
        (promised > 0 ? ", " + std::to_string(promised >> 20) + " MiB of them for uploads under way" : "") +
        "); free some space there" + claim.then);
  }
}

std::unique_ptr<BlobStore::Writer> BlobStore::NewWriter(const ContentHash& hash, uint64_t size, For purpose) {
  FileOf(hash);
  auto impl = std::make_unique<Writer::Impl>();
  impl->store = this;
  if (purpose == For::kClient) {
    // Promised before it is checked: of two that come at once, each would find room for itself alone.
    impl->promised = size;
    CheckSpace(size, purpose, promised_.fetch_add(size));
  } else {
    CheckSpace(size, purpose);
  }
  impl->hash = hash;
  impl->size = size;
  impl->temporary = folder_ / "temporary" / std::to_string(++temporary_);
  impl->fd = open(impl->temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (impl->fd < 0) Fail(impl->temporary, "made");
  return std::unique_ptr<Writer>(new Writer(std::move(impl)));
}

void BlobStore::Writer::Append(std::string_view bytes) {
  if (bytes.size() > impl_->size - impl_->written) {
    throw Error(ErrorKind::kInvalidInput, "content " + impl_->hash.hex + " is longer than the " +
                                              std::to_string(impl_->size) + " bytes announced");
  }
  impl_->sha.Add(bytes);
  impl_->written += bytes.size();
  const uint64_t kept = std::min<uint64_t>(impl_->promised, bytes.size());
  while (!bytes.empty()) {
    const ssize_t count = write(impl_->fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) Fail(impl_->temporary, "written");
    bytes.remove_prefix(static_cast<size_t>(count));
  }
  impl_->Keep(kept);
}

void BlobStore::Writer::Commit() {
  // Step 1: the content is what it says it is.
  if (impl_->written != impl_->size || impl_->sha.Finish() != impl_->hash) {
    throw Error(ErrorKind::kCorrupt, "content " + impl_->hash.hex + " came damaged (" + std::to_string(impl_->written) +
                                         " of " + std::to_string(impl_->size) +
                                         " bytes); did the file change while it was sent?");
  }
  // Step 2: on disk under its temporary name.
  if (fsync(impl_->fd) != 0) Fail(impl_->temporary, "synchronised");
  CrashPoint("blob-written");
  // Step 3: its name, then its row.
  const fs::path file = impl_->store->FileOf(impl_->hash);
  std::lock_guard lock(impl_->store->names_);
  if (fs::create_directories(file.parent_path())) SyncFolder(impl_->store->folder_);
  if (rename(impl_->temporary.c_str(), file.c_str()) != 0) Fail(file, "named");
  impl_->temporary.clear();
  SyncFolder(file.parent_path());
  CrashPoint("blob-renamed");
  impl_->store->store_.AddBlob(impl_->hash, impl_->size, impl_->store->Now());
  CrashPoint("blob-committed");
}

ContentHash BlobStore::Put(std::string_view bytes, For purpose) {
  const ContentHash hash = Sha256(bytes);
  if (!Have({hash}).empty()) return hash;
  auto writer = NewWriter(hash, bytes.size(), purpose);
  writer->Append(bytes);
  writer->Commit();
  return hash;
}

std::vector<ContentHash> BlobStore::Have(const std::vector<ContentHash>& hashes) {
  for (const auto& hash : hashes) FileOf(hash);
  return store_.HaveBlobs(hashes, Now());
}

fs::path BlobStore::PathOf(const ContentHash& hash) const {
  auto file = FileOf(hash);
  if (!fs::exists(file)) throw Error(ErrorKind::kNotFound, "the coordinator has no content " + hash.hex);
  return file;
}

Bytes BlobStore::Read(const ContentHash& hash) const {
  std::ifstream in(PathOf(hash), std::ios::binary);
  Bytes bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (Sha256(bytes) != hash)
    throw Error(ErrorKind::kCorrupt,
                "the stored content " + hash.hex + " is damaged: the disk of the store has a fault");
  return bytes;
}

void BlobStore::Drop(const ContentHash& hash) {
  std::lock_guard lock(names_);
  std::error_code ignored;
  if (store_.DropBlob(hash)) fs::remove(FileOf(hash), ignored);
}

size_t BlobStore::Collect() {
  std::lock_guard lock(names_);
  const auto gone = store_.CollectBlobs(Now() - options_.grace.count());
  for (const auto& hash : gone) {
    std::error_code ignored;
    fs::remove(FileOf(hash), ignored);  // what stays behind is an orphan of the next start
  }
  return gone.size();
}

}  // namespace lodestar
