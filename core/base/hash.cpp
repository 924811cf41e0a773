#include "core/base/hash.h"

#include "core/base/sha256_stream.h"

namespace lodestar {

ContentHash Sha256(std::string_view bytes) {
  Sha256Stream stream;
  stream.Add(bytes);
  return stream.Finish();
}

bool IsContentHash(std::string_view hex) {
  if (hex.size() != 64) return false;
  for (const char c : hex)
    if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return false;
  return true;
}

}  // namespace lodestar
