// That a store has one coordinator on this machine: held by the object, and gone with the process however that ends.
#pragma once

#include <filesystem>

namespace lodestar {

class StoreLock {
 public:
  // Makes the folder where it is missing. Throws Error(kConflict) where another holds the store, (kIo).
  explicit StoreLock(const std::filesystem::path& folder);
  ~StoreLock();
  StoreLock(const StoreLock&) = delete;
  StoreLock& operator=(const StoreLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace lodestar
