// Scene files on this machine's disk, by content: least recently used out first. Several workers may share a folder.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>

#include "core/base/file_lock.h"
#include "rpc/types.h"

namespace lodestar {

class AssetCache {
 public:
  // `fetch` brings content into a file that does not exist yet (WorkClient::FetchAsset).
  using Fetch = std::function<void(const ContentHash&, const std::filesystem::path&)>;
  // Removes what workers that were killed have left in `folder`.
  AssetCache(const std::filesystem::path& folder, uint64_t limit_bytes);
  ~AssetCache();

  // Makes a folder that holds exactly the manifest's files under their names; nothing outside of it is written. Removed
  // by the caller. Throws Error(kIo) for what is wrong with the cache, and what `fetch` throws.
  std::filesystem::path Materialise(const SceneManifest& manifest, const Fetch& fetch);

 private:
  std::filesystem::path FileOf(const ContentHash& hash) const {
    return folder_ / "content" / hash.hex.substr(0, 2) / hash.hex;
  }
  void Link(const ContentHash& hash, const std::filesystem::path& to, const Fetch& fetch);
  void Evict();

  const std::filesystem::path folder_;
  const uint64_t limit_bytes_;
  std::filesystem::path own_;  // scenes and files on their way, in a folder that no other worker has
  std::unique_ptr<FileLock> own_lock_;
  std::mutex mutex_;
  uint64_t last_ = 0;
};

}  // namespace lodestar
