#include "coordinator/shard_table.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"

namespace lodestar {

ShardTable::ShardTable(ShardedWork& work, size_t most_bytes)
    : work_(work), most_bytes_(most_bytes), shards_(work.count()) {}

void ShardTable::Run(const std::function<void()>& between) {
  // However it ends, with an exception too: leases are void, and no thread is left within the work.
  struct Leave {
    ShardTable& table;
    ~Leave() {
      std::unique_lock lock(table.mutex_);
      table.running_ = false;
      table.Void([](const Granted&) { return true; });
      table.changed_.wait(lock, [&] { return table.visitors_ == 0; });
    }
  } leave{*this};
  const auto count = static_cast<uint32_t>(shards_.size());
  while (true) {
    ParallelFor<tbb::simple_partitioner>(count, [&](uint32_t) {
      {
        std::lock_guard lock(mutex_);
        if (!NextHere()) return;
      }
      between();
      DoOne();
    });
    // What is left now is being taken in, and comes back if it is no answer.
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return done_ == count || NextHere(); });
    if (done_ == count) return;
  }
}

// The first that nobody has begun, else the one that was leased last: the others should be about to come.
std::optional<uint32_t> ShardTable::NextHere() const {
  const auto free = std::ranges::find(shards_, Phase::kFree, &Shard::phase);
  if (free != shards_.end()) return static_cast<uint32_t>(free - shards_.begin());
  const auto leased = std::ranges::find(shards_, Phase::kLeased, &Shard::phase);
  if (leased != shards_.end()) return static_cast<uint32_t>(leased - shards_.begin());
  return std::nullopt;
}

void ShardTable::Void(const std::function<bool(const Granted&)>& which) {
  std::erase_if(leases_, [&](const auto& lease) {
    if (!which(lease.second)) return false;
    void_.push_back({lease.first, lease.second.worker, {}});
    return true;
  });
}

std::vector<LeaseEntry> ShardTable::TakeVoid() {
  std::lock_guard lock(mutex_);
  return std::exchange(void_, {});
}

void ShardTable::DoOne() {
  uint32_t shard = 0;
  {
    std::lock_guard lock(mutex_);
    const auto next = NextHere();
    if (!next) return;
    shard = *next;
    Void([&](const Granted& granted) { return granted.shard == shard; });
    shards_[shard].phase = Phase::kTaken;
  }
  work_.DoHere(shard);  // where it throws, Run() ends
  std::lock_guard lock(mutex_);
  shards_[shard].phase = Phase::kDone;
  ++done_;
  changed_.notify_all();
}

bool ShardTable::Grant(LeaseId lease, const WorkerId& worker) {
  std::lock_guard lock(mutex_);
  if (!running_) return false;
  for (uint32_t shard = static_cast<uint32_t>(shards_.size()); shard-- > 0;) {
    if (shards_[shard].phase != Phase::kFree || shards_[shard].stays) continue;
    shards_[shard].phase = Phase::kLeased;
    leases_.emplace(lease, Granted{shard, worker});
    return true;
  }
  return false;
}

Bytes ShardTable::Describe(LeaseId lease) {
  uint32_t shard = 0;
  {
    std::lock_guard lock(mutex_);
    const auto it = leases_.find(lease);
    if (it == leases_.end()) return {};
    shard = it->second.shard;
    ++visitors_;
  }
  struct Leave {
    ShardTable& table;
    ~Leave() {
      std::lock_guard lock(table.mutex_);
      --table.visitors_;
      table.changed_.notify_all();
    }
  } leave{*this};
  Bytes description = work_.Describe(shard);
  if (!description.empty() && description.size() <= most_bytes_) return description;
  std::lock_guard lock(mutex_);
  if (leases_.erase(lease) > 0) {
    shards_[shard].phase = Phase::kFree;
    shards_[shard].stays = true;
  }
  return {};
}

bool ShardTable::Accept(LeaseId lease, std::string_view answer) {
  uint32_t shard = 0;
  {
    std::lock_guard lock(mutex_);
    const auto it = leases_.find(lease);
    if (it == leases_.end()) return false;
    shard = it->second.shard;
    leases_.erase(it);
    shards_[shard].phase = Phase::kTaken;
    ++visitors_;
  }
  bool taken = false;
  struct Leave {
    ShardTable& table;
    uint32_t shard;
    bool& taken;
    ~Leave() {
      std::lock_guard lock(table.mutex_);
      table.shards_[shard].phase = taken ? Phase::kDone : Phase::kFree;
      table.shards_[shard].stays = !taken;
      table.done_ += taken;
      table.accepted_ += taken;
      --table.visitors_;
      table.changed_.notify_all();
    }
  } leave{*this, shard, taken};
  work_.Accept(shard, answer);
  taken = true;
  return true;
}

void ShardTable::Release(LeaseId lease) {
  std::lock_guard lock(mutex_);
  const auto it = leases_.find(lease);
  if (it == leases_.end()) return;
  shards_[it->second.shard].phase = Phase::kFree;
  leases_.erase(it);
  changed_.notify_all();
}

bool ShardTable::Holds(LeaseId lease) const {
  std::lock_guard lock(mutex_);
  return leases_.contains(lease);
}

uint32_t ShardTable::accepted() const {
  std::lock_guard lock(mutex_);
  return accepted_;
}

}  // namespace lodestar
