#include "core/base/sealed_bytes.h"

#include "core/base/hash.h"

namespace lodestar {
namespace {

constexpr size_t kHeaderSize = 8, kChecksumSize = 8;

uint64_t Checksum(std::string_view bytes) {
  uint64_t hash = Mix64(bytes.size() + 0x9e3779b97f4a7c15ULL);
  size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    uint64_t word;
    std::memcpy(&word, bytes.data() + at, 8);
    hash = Mix64(hash ^ word);
  }
  uint64_t last = 0;
  if (at < bytes.size()) std::memcpy(&last, bytes.data() + at, bytes.size() - at);
  return Mix64(hash ^ last);
}

}  // namespace

ByteWriter OpenDocument(uint32_t magic, uint32_t version) {
  ByteWriter out;
  out.Put(magic);
  out.Put(version);
  return out;
}

Bytes Seal(ByteWriter&& document) {
  const uint64_t checksum = Checksum(document.bytes());
  document.Put(checksum);
  return document.Take();
}

std::string_view OpenSealed(std::string_view bytes, uint32_t magic, uint32_t version, const std::string& what) {
  ByteReader header(bytes, what);
  if (bytes.size() < kHeaderSize + kChecksumSize) header.Fail("ends early");
  if (header.Get<uint32_t>() != magic) header.Fail("is another kind of document, or damaged");
  const auto found = header.Get<uint32_t>();
  // The version is judged before the checksum: another version may seal differently.
  if (found != version) {
    throw Error(ErrorKind::kConflict, what + " has format version " + std::to_string(found) +
                                          ", this program reads version " + std::to_string(version) +
                                          "; use the release that wrote it, or start the job again");
  }
  uint64_t stored;
  std::memcpy(&stored, bytes.data() + bytes.size() - kChecksumSize, kChecksumSize);
  if (stored != Checksum(bytes.substr(0, bytes.size() - kChecksumSize))) {
    throw Error(ErrorKind::kCorrupt,
                what + " is damaged: its checksum does not fit its " + std::to_string(bytes.size()) + " bytes");
  }
  return bytes.substr(kHeaderSize, bytes.size() - kHeaderSize - kChecksumSize);
}

}  // namespace lodestar
