// The process in which a worker tries a scene first: what it says, and what is said of it when it dies.
#include "worker/compile_trial.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/farm/support/box.h"
#include "tests/farm/support/farm_fixture.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

namespace fs = std::filesystem;

struct CompileTrialTest : testing::Test {
  TemporaryFolder folder;
  JobDescription description;
  StopToken stop;
  CompileTrial::Options options{LODESTAR_BINARY_DIR "/bin/lodestar-worker", uint64_t{4} << 30};

  CompileTrialTest() {
    WriteBox(folder.path() / "scene");
    description.scene.main = "box.pbrt";
    description.spec = BoxJob("path", 4);
  }
  // What the trial says; empty: compiled.
  std::string Run(ErrorKind* kind = nullptr) {
    try {
      bytes = CompileTrial(options).Run(description, folder.path() / "scene", stop);
      return "";
    } catch (const Error& error) {
      if (kind) *kind = error.kind();
      return error.what();
    }
  }
  // A program that does this instead.
  void Instead(const std::string& shell) {
    options.program = folder.path() / "program";
    std::ofstream(options.program) << "#!/bin/sh\n" << shell << "\n";
    fs::permissions(options.program, fs::perms::owner_all);
  }
  uint64_t bytes = 0;
};

TEST_F(CompileTrialTest, SaysHowMuchMemoryASceneTakes) {
  EXPECT_EQ(Run(), "");
  EXPECT_GT(bytes, uint64_t{4} << 20);
  EXPECT_LT(bytes, options.memory_bytes);
  // Nothing is left beside the scene.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST_F(CompileTrialTest, ErrorsOfTheSceneAreItsOwn) {
  std::ofstream(folder.path() / "scene" / "block.pbrt") << "Shape \"teapot\"\n";
  ErrorKind kind = ErrorKind::kIo;
  EXPECT_NE(Run(&kind).find("block.pbrt:1:"), std::string::npos);
  EXPECT_NE(kind, ErrorKind::kIo) << "which would be the worker's fault";
}

TEST_F(CompileTrialTest, ADeathNamesTheSceneAndTheSignal) {
  Instead("kill -SEGV $$");
  ErrorKind kind = ErrorKind::kInvalidInput;
  const auto said = Run(&kind);
  EXPECT_NE(said.find("box.pbrt"), std::string::npos) << said;
  EXPECT_NE(said.find("signal 11"), std::string::npos) << said;
  EXPECT_EQ(kind, ErrorKind::kIo);
  Instead("exit 7");
  EXPECT_NE(Run().find("code 7"), std::string::npos);
  options.program = folder.path() / "none";
  EXPECT_NE(Run().find("cannot be started"), std::string::npos);
}

TEST_F(CompileTrialTest, CtrlCInTheTerminalIsTheWorkersAlone) {
  Instead("test $(ps -o pgid= $$) -eq $$ && exit 7");
  EXPECT_NE(Run().find("code 7"), std::string::npos) << "it must lead a group of its own";
}

TEST_F(CompileTrialTest, AStopRequestEndsIt) {
  Instead("exec sleep 1000");
  std::thread other([&] { stop.Request(); });
  const auto start = std::chrono::steady_clock::now();
  EXPECT_NE(Run(), "");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  other.join();
}

}  // namespace
}  // namespace lodestar
