#include "core/base/file_lock.h"

#include <gtest/gtest.h>

#include <optional>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using Mode = FileLock::Mode;

TEST(FileLock, OneAtATime) {
  const TemporaryFolder folder;
  std::optional<FileLock> first(std::in_place, folder.path() / "lock", Mode::kTry, "--store");
  EXPECT_TRUE(first->held());
  EXPECT_FALSE(FileLock(folder.path() / "lock", Mode::kTry, "--store").held());
  first.reset();
  EXPECT_TRUE(FileLock(folder.path() / "lock", Mode::kWait, "--store").held());
}

TEST(FileLock, AFolderThatIsNotThereIsAnErrorThatNamesTheOption) {
  const TemporaryFolder folder;
  try {
    FileLock(folder.path() / "none" / "lock", Mode::kTry, "--store");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kIo);
    EXPECT_NE(std::string(error.what()).find("--store"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lodestar
