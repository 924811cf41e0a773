// Who does which shard of one piece of work: this process, from the first on, and workers that are offered the rest,
// from the last. What a worker holds and has not brought is done here in the end, so nobody is ever waited for, and a
// worker that is lost costs nothing. Thread-safe.
//
//   free --Grant--> leased --Accept--> done
//     |                '--(nothing else is left)--.
//     '--------------------------------------> done here
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "coordinator/lease_table.h"
#include "core/base/shards.h"

namespace lodestar {

class ShardTable {
 public:
  // `most_bytes`: shards that take more to describe are done here.
  ShardTable(ShardedWork& work, size_t most_bytes);

  // Does what nobody else does, on this process's threads, until all is done; then the work is touched no more.
  // `between` is called before each shard on the thread that is to do it, and may call Grant.
  void Run(const std::function<void()>& between);

  // For workers; each may be called before, while and after Run().
  // Whether there was one to give out.
  bool Grant(LeaseId lease, const WorkerId& worker);
  // Of a lease, to be sent; empty where it is void: it is over by now, or no worker should do it.
  Bytes Describe(LeaseId lease);
  // Whether it was of use. Throws Error(kCorrupt) where it is no answer; the shard is done here then.
  bool Accept(LeaseId lease, std::string_view answer);
  void Release(LeaseId lease);
  bool Holds(LeaseId lease) const;
  // Leases that have become void unanswered, since the last call.
  std::vector<LeaseEntry> TakeVoid();
  uint32_t count() const { return static_cast<uint32_t>(shards_.size()); }
  uint32_t accepted() const;  // of them, from workers

 private:
  enum class Phase : uint8_t { kFree, kLeased, kTaken, kDone };
  struct Shard {
    Phase phase = Phase::kFree;
    bool stays = false;  // not for workers
  };
  struct Granted {
    uint32_t shard;
    WorkerId worker;
  };
  void DoOne();
  // With mutex_ held.
  std::optional<uint32_t> NextHere() const;
  void Void(const std::function<bool(const Granted&)>& which);

  ShardedWork& work_;
  const size_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Shard> shards_;
  std::map<LeaseId, Granted> leases_;
  std::vector<LeaseEntry> void_;
  uint32_t done_ = 0, accepted_ = 0;
  int visitors_ = 0;     // threads of workers' calls that are within the work
  bool running_ = true;  // until Run() has returned
};

}  // namespace lodestar
