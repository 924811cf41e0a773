// Canonical bytes: little-endian, fixed width, no padding. States and contributions are written with these, and hashes
// are of these bytes.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.h"

namespace lodestar {

using Bytes = std::string;

// Four letters that name a kind of document, as they appear in its first four bytes.
constexpr uint32_t DocumentMagic(const char (&letters)[5]) {
  return static_cast<uint32_t>(static_cast<unsigned char>(letters[0])) |
         static_cast<uint32_t>(static_cast<unsigned char>(letters[1])) << 8 |
         static_cast<uint32_t>(static_cast<unsigned char>(letters[2])) << 16 |
         static_cast<uint32_t>(static_cast<unsigned char>(letters[3])) << 24;
}

class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void Put(T value) {
    const size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  // As they are, without their number.
  void PutRaw(std::string_view bytes) { bytes_.append(bytes); }
  void PutString(std::string_view text) {
    Put<uint64_t>(text.size());
    bytes_.append(text);
  }
  // T must be free of padding: arithmetic, or a struct of equally wide arithmetic members.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void PutSpan(std::span<const T> values) {
    Put<uint64_t>(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  template <class T>
  void PutVector(const std::vector<T>& values) {
    PutSpan(std::span<const T>(values));
  }
  const Bytes& bytes() const { return bytes_; }
  Bytes Take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

// Throws Error(kCorrupt) when the bytes end early; `what` names the document in that message.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, std::string what) : bytes_(bytes), what_(std::move(what)) {}

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T> T Get() {
    T value;
    std::memcpy(&value, Need(sizeof(T)), sizeof(T));
    return value;
  }
  bool GetFlag() {
    const auto flag = Get<uint8_t>();
    if (flag > 1) Fail("has a flag that is neither set nor clear");
    return flag == 1;
  }
  std::string GetString() { return std::string(GetView()); }
  std::string_view GetRaw(size_t size) { return {Need(size), size}; }
  // The next bytes, not yet read; null where there are fewer.
  const char* Peek(size_t size) const { return size <= remaining() ? bytes_.data() + at_ : nullptr; }
  // A string where it lies, within the bytes that are read.
  std::string_view GetView() {
    const auto size = GetSize(1);
    return {Need(size), size};
  }
  template <class T>
  requires std::is_trivially_copyable_v<T> std::vector<T> GetVector() {
    const auto size = GetSize(sizeof(T));
    std::vector<T> values(size);
    if (size > 0) std::memcpy(values.data(), Need(size * sizeof(T)), size * sizeof(T));
    return values;
  }
  // What PutVector wrote, where it lies: it need not be aligned.
  std::string_view GetVectorBytes(size_t element) {
    const auto size = GetSize(element) * element;
    return {Need(size), size};
  }
  size_t remaining() const { return bytes_.size() - at_; }
  // Throws unless the document's first bytes name this kind and this version. `many`: what is read is called by a
  // plural, in the messages.
  void ExpectHeader(uint32_t magic, uint32_t version, bool many = false) {
    if (Get<uint32_t>() != magic) Fail(many ? "do not begin like ones" : "does not begin like one");
    const auto found = Get<uint32_t>();
    if (found != version) {
      Fail((many ? "have version " : "has version ") + std::to_string(found) + ", known is " + std::to_string(version));
    }
  }
  // Throws unless everything was read.
  void ExpectEnd() const {
    if (remaining() != 0) Fail("has bytes after its end");
  }
  [[noreturn]] void Fail(const std::string& why) const {
    throw Error(ErrorKind::kCorrupt,
                what_ + " " + why + " (at byte " + std::to_string(at_) + " of " + std::to_string(bytes_.size()) + ")");
  }

 private:
  // A length that cannot fit the rest of the bytes is refused before anything is allocated for it.
  size_t GetSize(size_t element) {
    const uint64_t size = Get<uint64_t>();
    if (size > remaining() / element) Fail("names a length beyond its end");
    return static_cast<size_t>(size);
  }
  const char* Need(size_t size) {
    if (size > remaining()) Fail("ends early");
    const char* at = bytes_.data() + at_;
    at_ += size;
    return at;
  }

  std::string_view bytes_;
  std::string what_;
  size_t at_ = 0;
};

// zstd, lossless. Decompress takes one frame and throws Error(kCorrupt), also where the announced size exceeds
// max_size. The memory that it takes follows what the frame holds, not what it announces.
Bytes Compress(std::string_view bytes, int level = 1);
Bytes Decompress(std::string_view bytes, const std::string& what, uint64_t max_size = uint64_t{1} << 34);

}  // namespace lodestar
