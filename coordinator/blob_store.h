// Content-addressed files. A blob is there when its row is: written to a temporary name, synchronised (file and
// folder), renamed, then the row. A crash in between leaves a file without a row, which the next start removes.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>

#include "coordinator/job_store.h"

namespace lodestar {

class BlobStore {
 public:
  struct Options {
    // Of the disk, kept free of uploads for jobs that run; how much of it what a job writes must leave: For.
    uint64_t reserve_bytes = uint64_t{256} << 20;
    std::chrono::milliseconds grace = std::chrono::minutes(10);  // an unneeded blob lives this long after its last use
    std::function<uint64_t()> free_bytes;                        // injected by tests; empty: asks the file system
    std::function<int64_t()> now_unix_ms;                        // injected by tests; empty: the system's clock
  };
  // What is written where the disk is nearly full: what cannot be had again may take more of the reserve. What would
  // leave less than its part is refused, long before SQLite's writes would fail.
  enum class For {
    kClient,      // uploads and submissions leave all of the reserve
    kCheckpoint,  // leaves half of it: without one a job goes on
    kResult,      // leaves a quarter: without it the job was in vain
  };
  BlobStore(const std::filesystem::path& folder, JobStore& store, Options options);

  // Content that arrives in parts.
  class Writer {
   public:
    ~Writer();
    void Append(std::string_view
                    bytes);  // throws ExhaustedError (disk nearly full), Error(kInvalidInput) beyond the announced size
    void Commit();           // throws Error(kCorrupt) where size or hash differ

   private:
    friend class BlobStore;
    struct Impl;
    explicit Writer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
  };
  // Both throw ExhaustedError as CheckSpace does.
  std::unique_ptr<Writer> NewWriter(const ContentHash& hash, uint64_t size, For purpose = For::kClient);
  ContentHash Put(std::string_view bytes, For purpose = For::kClient);

  std::vector<ContentHash> Have(const std::vector<ContentHash>& hashes);
  // Throws Error(kNotFound).
  std::filesystem::path PathOf(const ContentHash& hash) const;
  Bytes Read(const ContentHash& hash) const;
  // Removes one blob at once, if no job needs it: a checkpoint that has a successor.
  void Drop(const ContentHash& hash);
  // Removes what no job needs; returns how many.
  size_t Collect();
  // Throws ExhaustedError where `bytes` more would leave less of the reserve than they must: for a client after all
  // that uploads under way have still to bring, for a job now, since an upload can be repeated.
  void CheckSpace(uint64_t bytes, For purpose = For::kClient) const {
    CheckSpace(bytes, purpose, purpose == For::kClient ? promised_.load() : 0);
  }

 private:
  std::filesystem::path FileOf(const ContentHash& hash) const;
  int64_t Now() const;
  void CheckSpace(uint64_t bytes, For purpose, uint64_t promised) const;
  std::filesystem::path folder_;
  JobStore& store_;
  Options options_;
  std::mutex names_;  // between a rename with its row, and a collection with its removals
  std::atomic<uint64_t> temporary_{0};
  std::atomic<uint64_t> promised_{0};  // bytes that clients' writers have announced and not written yet
};

}  // namespace lodestar
