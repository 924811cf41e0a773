#include "worker/asset_cache.h"

#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/sha256_stream.h"

namespace lodestar {
namespace fs = std::filesystem;

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
  const FileLock alone(folder_ / "lock", FileLock::Mode::kWait, "--cache");
  for (const auto& entry : fs::directory_iterator(folder_ / "workers", error))
    if (FileLock(entry.path() / "lock", FileLock::Mode::kTry, "--cache").held()) fs::remove_all(entry.path(), error);
  std::string own = (folder_ / "workers" / "XXXXXX").string();
  if (!mkdtemp(own.data())) throw Error(ErrorKind::kIo, own + " cannot be made: " + std::strerror(errno));
  own_ = own;
  own_lock_ = std::make_unique<FileLock>(own_ / "lock", FileLock::Mode::kWait, "--cache");
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
