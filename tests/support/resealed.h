// Documents that are wrong behind their checksum.
#pragma once

#include <functional>

#include "core/base/sealed_bytes.h"

namespace lodestar {

// The same document with other content, its checksum right.
inline Bytes Resealed(const Bytes& document, const std::function<void(Bytes*)>& change) {
  uint32_t magic, version;
  std::memcpy(&magic, document.data(), 4);
  std::memcpy(&version, document.data() + 4, 4);
  Bytes content(OpenSealed(document, magic, version, "document"));
  change(&content);
  ByteWriter out = OpenDocument(magic, version);
  out.PutRaw(content);
  return Seal(std::move(out));
}

}  // namespace lodestar
