// SHA-256 of content that arrives in parts.
#pragma once

#include <filesystem>
#include <memory>

#include "core/base/hash.h"

namespace lodestar {

class Sha256Stream {
 public:
  Sha256Stream();
  ~Sha256Stream();
  void Add(std::string_view bytes);
  ContentHash Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Throws Error(kNotFound) or (kIo).
ContentHash Sha256OfFile(const std::filesystem::path& path, uint64_t* size = nullptr);

}  // namespace lodestar
