#include "worker/asset_cache.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "core/base/log.h"
#include "rpc/sha256_stream.h"

namespace lodestar {
namespace fs = std::filesystem;

// flock: it goes with the process however that ends, and holds between containers that share the folder, where process
// ids say nothing. Of a file and not of its folder, which network file systems do not lock.
class AssetCache::Lock {
 public:
  enum Mode { kWait = 0, kTry = LOCK_NB };
  // Throws Error(kIo) where it cannot be asked for.
  Lock(const fs::path& file, Mode mode) : file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
    int failed = file_ < 0 ? errno : 0;
    while (failed == 0 && !held_) {
      held_ = flock(file_, LOCK_EX | mode) == 0;
      if (!held_ && errno == EWOULDBLOCK) return;
      if (!held_ && errno != EINTR) failed = errno;
    }
    if (failed == 0) return;
    if (file_ >= 0) close(file_);
    throw Error(ErrorKind::kIo, file.string() + " cannot be locked: " + std::strerror(failed) +
                                    "; choose a folder on a local disk with --cache");
  }
  ~Lock() { close(file_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
  bool held() const { return held_; }

 private:
  const int file_;
  bool held_ = false;
};

AssetCache::AssetCache(const fs::path& folder, uint64_t limit_bytes)
    : folder_(fs::absolute(folder)), limit_bytes_(limit_bytes) {
  std::error_code error;
  for (const char* part : {"content", "workers"}) {
    fs::create_directories(folder_ / part, error);
    if (error)
      throw Error(ErrorKind::kIo, "the cache folder " + (folder_ / part).string() +
                                      " cannot be made: " + error.message() + "; choose another with --cache");
  }
  // One at a time, or a worker would take for left behind what another has made and not locked yet.
  const Lock alone(folder_ / "lock", Lock::kWait);
  for (const auto& entry : fs::directory_iterator(folder_ / "workers", error))
    if (Lock(entry.path() / "lock", Lock::kTry).held()) fs::remove_all(entry.path(), error);
  std::string own = (folder_ / "workers" / "XXXXXX").string();
  if (!mkdtemp(own.data())) throw Error(ErrorKind::kIo, own + " cannot be made: " + std::strerror(errno));
  own_ = own;
  own_lock_ = std::make_unique<Lock>(own_ / "lock", Lock::kWait);
}

AssetCache::~AssetCache() {
  std::error_code ignored;
  fs::remove_all(own_, ignored);
}

void AssetCache::Link(const ContentHash& hash, const fs::path& to, const Fetch& fetch) {
  const fs::path file = FileOf(hash);
  for (int attempt = 0; attempt < 3; ++attempt) {
    std::error_code error;
    if (fs::exists(file, error)) {
      // A disk that lies is found here, not in a picture.
      ContentHash found;
      try {
        found = Sha256OfFile(file);
      } catch (const Error& unread) {
        if (!fs::exists(file, error)) continue;  // another worker evicted it in between
        throw Error(ErrorKind::kIo,
                    std::string(unread.what()) + "; check its permissions, or choose another folder with --cache");
      }
      if (found != hash) {
        spdlog::warn("cached content {} is damaged: fetching it again", hash.hex);
        fs::remove(file, error);
        continue;
      }
      fs::last_write_time(file, fs::file_time_type::clock::now(), error);
      fs::create_hard_link(file, to, error);
      if (error) fs::copy_file(file, to, error);
      if (!error) return;
      if (error != std::errc::no_such_file_or_directory)
        throw Error(ErrorKind::kIo, to.string() + " cannot be written: " + error.message());
      continue;  // evicted just now
    }
    const fs::path temporary = own_ / std::to_string(++last_);
    fetch(hash, temporary);
    fs::create_directories(file.parent_path());
    fs::rename(temporary, file);
  }
  throw Error(ErrorKind::kIo, "content " + hash.hex + " does not stay in the cache folder " + folder_.string() +
                                  ": is its disk full or failing?");
}

fs::path AssetCache::Materialise(const SceneManifest& manifest, const Fetch& fetch) {
  manifest.Validate();  // names stay inside, whoever sent them
  std::lock_guard lock(mutex_);
  const fs::path folder = own_ / std::to_string(++last_);
  fs::create_directories(folder);
  try {
    for (const auto& [name, file] : manifest.files) {
      const fs::path to = folder / name;
      fs::create_directories(to.parent_path());
      Link(file.hash, to, fetch);
    }
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    throw;
  }
  Evict();
  return folder;
}

void AssetCache::Evict() {
  struct Entry {
    fs::path path;
    fs::file_time_type used;
    uint64_t size;
  };
  std::vector<Entry> entries;
  uint64_t total = 0;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "content", error)) {
    if (!entry.is_regular_file(error)) continue;
    entries.push_back({entry.path(), entry.last_write_time(error), entry.file_size(error)});
    total += entries.back().size;
  }
  if (total <= limit_bytes_) return;
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const auto& entry : entries) {
    if (total <= limit_bytes_) break;
    fs::remove(entry.path, error);  // scenes that use it hold links of their own
    total -= entry.size;
  }
}

}  // namespace lodestar
