#include "core/base/bytes.h"

#include <zstd.h>

#include "core/base/check.h"

namespace lodestar {

Bytes Compress(std::string_view bytes, int level) {
  Bytes out(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), level);
  LODESTAR_CHECK(!ZSTD_isError(size));
  out.resize(size);
  return out;
}

Bytes Decompress(std::string_view bytes, const std::string& what, uint64_t max_size) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN)
    throw Error(ErrorKind::kCorrupt, what + " is not a zstd frame");
  if (size > max_size)
    throw Error(ErrorKind::kCorrupt, what + " announces " + std::to_string(size) + " bytes, more than the limit of " +
                                         std::to_string(max_size));
  Bytes out(size, '\0');
  const size_t got = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(got) || got != size)
    throw Error(ErrorKind::kCorrupt,
                what + " does not decompress: " + (ZSTD_isError(got) ? ZSTD_getErrorName(got) : "short frame"));
  return out;
}

}  // namespace lodestar
