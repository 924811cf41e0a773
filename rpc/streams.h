// Cutting content into the chunks of a stream.
#pragma once

#include <string_view>

#include "rpc/types.h"

namespace lodestar {

// Calls `send(part)` for each part of at most kChunkBytes; once, with nothing, for empty content. Stops where `send`
// returns false.
template <class Send>
bool ForEachChunk(std::string_view bytes, Send&& send) {
  size_t at = 0;
  do {
    const auto part = bytes.substr(at, kChunkBytes);
    if (!send(part)) return false;
    at += part.size();
  } while (at < bytes.size());
  return true;
}

}  // namespace lodestar
