#include "core/base/sha256_stream.h"

#include <openssl/evp.h>

#include <fstream>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"

namespace lodestar {

struct Sha256Stream::Impl {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~Impl() { EVP_MD_CTX_free(context); }
};

Sha256Stream::Sha256Stream() : impl_(std::make_unique<Impl>()) {
  LODESTAR_CHECK(impl_->context != nullptr && EVP_DigestInit_ex(impl_->context, EVP_sha256(), nullptr) == 1);
}
Sha256Stream::~Sha256Stream() = default;

void Sha256Stream::Add(std::string_view bytes) {
  LODESTAR_CHECK(EVP_DigestUpdate(impl_->context, bytes.data(), bytes.size()) == 1);
}

ContentHash Sha256Stream::Finish() {
  unsigned char digest[32];
  unsigned size = 0;
  LODESTAR_CHECK(EVP_DigestFinal_ex(impl_->context, digest, &size) == 1 && size == 32);
  ContentHash hash;
  hash.hex.reserve(64);
  for (const unsigned char byte : digest) {
    hash.hex += "0123456789abcdef"[byte >> 4];
    hash.hex += "0123456789abcdef"[byte & 15];
  }
  return hash;
}

ContentHash Sha256OfFile(const std::filesystem::path& path, uint64_t* size) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorKind::kNotFound, path.string() + " cannot be opened");
  Sha256Stream hash;
  std::vector<char> buffer(1 << 20);
  uint64_t total = 0;
  while (in) {
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<size_t>(in.gcount());
    hash.Add({buffer.data(), count});
    total += count;
  }
  if (in.bad()) throw Error(ErrorKind::kIo, path.string() + " cannot be read");
  if (size) *size = total;
  return hash.Finish();
}

}  // namespace lodestar
