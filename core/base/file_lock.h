// An exclusive lock on a file, among the processes of this machine.
#pragma once

#include <filesystem>
#include <string>

namespace lodestar {

class FileLock {
 public:
  enum class Mode { kWait, kTry };
  // Makes the file where it is missing, not its folder. Throws Error(kIo) where the lock cannot be asked for; `option`
  // is what chooses the file's folder, for the message.
  FileLock(const std::filesystem::path& file, Mode mode, const std::string& option);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  // False where another has it; with kTry only.
  bool held() const { return held_; }

 private:
  const int file_;
  bool held_ = false;
};

}  // namespace lodestar
