// scripts/demo.sh: one command that renders on a farm of its own, and leaves the results and nothing else.
#include "tests/client/run_program.h"
#include "tests/farm/support/farm_fixture.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

// Processes that have the line in their environment, which those that a script starts have from it.
size_t CountWith(const std::string& line) {
  size_t count = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    // Empty where it is no process, or not ours to read.
    const std::string lines = std::string(1, '\0') + ReadText(entry.path() / "environ");
    if (lines.find(std::string(1, '\0') + line + std::string(1, '\0')) != std::string::npos) ++count;
  }
  return count;
}

TEST(Demo, WritesItsFilesAndEndsWhatItStarted) {
  TemporaryFolder folder;
  const auto box = WriteBox(folder.path() / "scene");
  const auto log = folder.path() / "log", temporary = folder.path() / "temporary", out = folder.path() / "out";
  fs::create_directory(temporary);
  const std::string mark = "TMPDIR=" + temporary.string();
  Process demo({LODESTAR_SOURCE_DIR "/scripts/demo.sh", box.files.front().path.string(), "--method", "path", "--spp",
                "8", "-o", (out / "box.exr").string()},
               log, {"LODESTAR_BIN=" LODESTAR_BINARY_DIR "/bin", mark});
  size_t most = 0;
  EXPECT_TRUE(Eventually(seconds(60), [&] {
    most = std::max(most, CountWith(mark));
    return !demo.running();
  })) << ReadText(log);
  ASSERT_EQ(demo.Wait(seconds(1)), 0) << ReadText(log);
  EXPECT_GE(most, 4u) << "the script, a coordinator and two workers";
  EXPECT_EQ(CountWith(mark), 0u);
  EXPECT_TRUE(fs::is_empty(temporary));
  for (const char* file : {"box.exr", "box.png", "box.csv"}) {
    ASSERT_TRUE(fs::exists(out / file)) << file << "\n" << ReadText(log);
    EXPECT_GT(fs::file_size(out / file), 0u) << file;
  }
  if (RunProgram({"/usr/bin/python3", "-c", "import matplotlib"}).code != 0)
    GTEST_SKIP() << "no matplotlib under /usr/bin/python3, so no plot";
  EXPECT_TRUE(fs::exists(out / "box-error.png")) << ReadText(log);
}

}  // namespace
}  // namespace lodestar
