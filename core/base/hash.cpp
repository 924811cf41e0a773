#include "core/base/hash.h"

#include <openssl/evp.h>

#include "core/base/check.h"

namespace lodestar {

ContentHash Sha256(std::string_view bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  LODESTAR_CHECK(EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr) == 1 && size == 32);
  static constexpr char kDigits[] = "0123456789abcdef";
  ContentHash hash;
  hash.hex.reserve(64);
  for (unsigned int i = 0; i < size; ++i) {
    hash.hex.push_back(kDigits[digest[i] >> 4]);
    hash.hex.push_back(kDigits[digest[i] & 15]);
  }
  return hash;
}

bool IsContentHash(std::string_view hex) {
  if (hex.size() != 64) return false;
  for (const char c : hex)
    if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return false;
  return true;
}

}  // namespace lodestar
