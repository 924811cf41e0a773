#include "core/base/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace lodestar {

// flock: it goes with the process however that ends, and holds between containers that share the folder, where process
// ids say nothing. Of a file and not of its folder, which network file systems do not lock.
FileLock::FileLock(const std::filesystem::path& file, Mode mode, const std::string& option)
    : file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
  int failed = file_ < 0 ? errno : 0;
  while (failed == 0 && !held_) {
    held_ = flock(file_, LOCK_EX | (mode == Mode::kTry ? LOCK_NB : 0)) == 0;
    if (!held_ && errno == EWOULDBLOCK) return;
    if (!held_ && errno != EINTR) failed = errno;
  }
  if (failed == 0) return;
  if (file_ >= 0) close(file_);
  throw Error(ErrorKind::kIo, file.string() + " cannot be locked: " + std::strerror(failed) +
                                  "; choose a folder on a local disk with " + option);
}

FileLock::~FileLock() {
  close(file_);
}

}  // namespace lodestar
