// Bytes as the messages of a stream.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>

#include "core/base/bytes.h"
#include "rpc/streams.h"

namespace lodestar {

// Fills in the next part; false after the last.
template <class Chunk>
std::function<bool(Chunk*)> InChunks(std::shared_ptr<const Bytes> bytes) {
  return [bytes = std::move(bytes), at = size_t{0}](Chunk* chunk) mutable {
    if (at == bytes->size()) return false;
    const size_t count = std::min(kChunkBytes, bytes->size() - at);
    chunk->set_data(bytes->data() + at, count);
    at += count;
    return true;
  };
}

}  // namespace lodestar
