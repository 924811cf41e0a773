#include "coordinator/store_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace lodestar {

// flock, as it belongs to the open file: the kernel gives it up with a process that is killed. Not of SQLite's file,
// whose own locks are per transaction.
StoreLock::StoreLock(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(ErrorKind::kIo, "the store folder " + folder.string() + " cannot be made: " + error.message());
  const auto name = folder / "lock";
  file_ = open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  int failed = file_ < 0 ? errno : 0;
  while (failed == 0 && flock(file_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EINTR) failed = errno;
  }
  if (failed == 0) return;
  if (file_ >= 0) close(file_);
  if (failed == EWOULDBLOCK) {
    throw Error(ErrorKind::kConflict, "another coordinator of this machine holds the store " + folder.string() +
                                          ": stop it first, or take another --store");
  }
  throw Error(ErrorKind::kIo, name.string() + " cannot be locked: " + std::strerror(failed) +
                                  "; choose a folder on a local disk with --store");
}

StoreLock::~StoreLock() {
  close(file_);
}

}  // namespace lodestar
