// The envelope of every document that is kept or sent whole: magic, version, content, checksum. The checksum is a chain
// of bijections over 64-bit words, so a change within any one word is always found, and any other damage with a chance
// of 1 - 2^-64. It guards against accidents (disks, truncated files), not against forgery: that is what content hashes
// are for.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/bytes.h"

namespace lodestar {

// A writer whose first bytes are the envelope's; finish it with Seal.
ByteWriter OpenDocument(uint32_t magic, uint32_t version);
Bytes Seal(ByteWriter&& document);

// The content between header and checksum. Throws Error(kCorrupt) where magic or checksum do not fit and
// Error(kConflict) for another version; `what` names the document in the message. The view points into `bytes`.
std::string_view OpenSealed(std::string_view bytes, uint32_t magic, uint32_t version, const std::string& what);

}  // namespace lodestar
