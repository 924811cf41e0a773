#include "core/base/bytes.h"

#include <zstd.h>

#include <algorithm>
#include <memory>

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
  // What is announced is a claim: memory beyond the first piece is taken once what there was is full.
  constexpr uint64_t kFirstPiece = uint64_t{1} << 22;
  const std::unique_ptr<ZSTD_DStream, size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(), &ZSTD_freeDStream);
  LODESTAR_CHECK(stream != nullptr);
  Bytes out(std::min<uint64_t>(size, kFirstPiece), '\0');
  ZSTD_inBuffer from{bytes.data(), bytes.size(), 0};
  ZSTD_outBuffer to{out.data(), out.size(), 0};
  size_t left = ZSTD_decompressStream(stream.get(), &to, &from);
  while (left != 0 && !ZSTD_isError(left) && to.pos == to.size && to.size < size) {
    out.resize(std::min<uint64_t>(2 * out.size(), size));
    to = {out.data(), out.size(), to.pos};
    left = ZSTD_decompressStream(stream.get(), &to, &from);
  }
  if (left != 0 || to.pos != size || from.pos != from.size)
    throw Error(ErrorKind::kCorrupt, what + " does not decompress: " +
                                         (ZSTD_isError(left) ? ZSTD_getErrorName(left) : "not what it announces"));
  return out;
}

}  // namespace lodestar
