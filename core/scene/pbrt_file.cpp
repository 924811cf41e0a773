#include "core/scene/pbrt_file.h"

#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <system_error>

#include "core/base/error.h"

namespace lodestar {
namespace {

// A guard against decompression bombs; a mesh of this size would not fit the index type anyway.
constexpr size_t kMaxInflated = size_t{1} << 34;

std::string Inflate(const std::string& packed, const std::string& name) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 16) != Z_OK)
    throw Error(ErrorKind::kIo, name + ": cannot start decompression (out of memory?)");
  struct Ender {
    z_stream* s;
    ~Ender() { inflateEnd(s); }
  } ender{&stream};
  std::string out;
  size_t used = 0, consumed = 0;
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorKind::kCorrupt, name + ": gzip data " + why + " (after " + std::to_string(used) +
                                         " bytes); copy or compress the file again");
  };
  while (true) {
    if (out.size() - used < 1 << 16) out.resize(std::max<size_t>(out.size() * 2, size_t{1} << 18));
    constexpr size_t kChunk = size_t{1} << 30;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + consumed));
    stream.avail_in = static_cast<uInt>(std::min(packed.size() - consumed, kChunk));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + used);
    stream.avail_out = static_cast<uInt>(std::min(out.size() - used, kChunk));
    const uInt in = stream.avail_in, room = stream.avail_out;
    const int status = inflate(&stream, Z_NO_FLUSH);
    consumed += in - stream.avail_in;
    used += room - stream.avail_out;
    if (used > kMaxInflated) fail("is larger than 16 GiB");
    if (status == Z_STREAM_END) {
      if (consumed == packed.size()) break;
      inflateReset(&stream);  // gzip files may be concatenated
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      fail("is damaged");
    } else if (consumed == packed.size() && stream.avail_out > 0) {
      fail("ends early");
    }
  }
  out.resize(used);
  return out;
}

}  // namespace

std::string ReadFileMaybeGzip(const std::filesystem::path& path) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) throw Error(ErrorKind::kNotFound, path.string() + ": no such file");
  if (std::filesystem::is_directory(status))
    throw Error(ErrorKind::kNotFound, path.string() + " is a folder, not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorKind::kIo, path.string() + ": cannot be opened; check its permissions");
  const auto size = std::filesystem::file_size(path, code);
  std::string bytes;
  if (!code) bytes.resize(size);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (code || in.gcount() != static_cast<std::streamsize>(bytes.size()))
    throw Error(ErrorKind::kIo, path.string() + ": reading failed");
  if (bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b') return Inflate(bytes, path.string());
  return bytes;
}

}  // namespace lodestar
