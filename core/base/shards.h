// Work in independent pieces, shards, each with the same result wherever it is done: here, or by others to whom it is
// sent as bytes. Who does what is decided by a ShardRunner.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/bytes.h"

namespace lodestar {

// Several threads may be within it at once: each DoHere() or Accept() of a shard of its own, beside Describe() of any.
class ShardedWork {
 public:
  virtual ~ShardedWork() = default;
  virtual uint32_t count() const = 0;
  virtual void DoHere(uint32_t shard) = 0;
  // What another needs to do it; empty where there is nothing that could be left to others.
  virtual Bytes Describe(uint32_t shard) const = 0;
  // What another made of Describe()'s bytes, in place of DoHere(). Throws Error(kCorrupt) on anything else; then the
  // shard is as undone as it was.
  virtual void Accept(uint32_t shard, std::string_view answer) = 0;
};

class ShardRunner {
 public:
  virtual ~ShardRunner() = default;
  // Returns once every shard was done, in whatever order and place. What DoHere() throws passes through.
  virtual void Run(ShardedWork& work) = 0;
};

}  // namespace lodestar
