#include "client/outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/exit_code.h"
#include "client/plot.h"
#include "core/base/error.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

Image Gradient() {
  Image image;
  image.width = 5;
  image.height = 3;
  for (int i = 0; i < 15; ++i) {
    image.pixels.push_back(
        {0.1f * static_cast<float>(i), 100.0f / static_cast<float>(i + 1), 1e-7f * static_cast<float>(i)});
    image.variance.push_back(0.01f * static_cast<float>(i));
  }
  return image;
}

TEST(Outputs, FilesStandBesideTheImage) {
  const OutputPaths paths = OutputPaths::For("out/a.b.exr");
  EXPECT_EQ(paths.png, "out/a.b.png");
  EXPECT_EQ(paths.csv, "out/a.b.csv");
  EXPECT_EQ(paths.json, "out/a.b.json");
  EXPECT_EQ(paths.plot, "out/a.b-error.png");
  EXPECT_EQ(OutputPaths::For("x.png").png, "x.png");
  for (const char* name : {"x", "x.jpg", "x.exr.gz", "out/"}) EXPECT_THROW(OutputPaths::For(name), Error) << name;
}

TEST(Outputs, FloatFilesGiveTheSameBitsBack) {
  TemporaryFolder folder;
  const Image image = Gradient();
  for (const char* name : {"a.exr", "a.pfm"}) {
    WriteImage(folder / name, image, {{"lodestar:method", "path"}});
    const Image read = ReadImageFile(folder / name);
    EXPECT_EQ(read.width, 5u);
    EXPECT_EQ(read.height, 3u);
    EXPECT_EQ(read.pixels, image.pixels) << name;
  }
}

TEST(Outputs, AFolderThatCannotBeWrittenIsFoundBeforeTheRender) {
  TemporaryFolder folder;
  PrepareFolder(folder / "new/folder/x.exr");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "new/folder"));
  folder.Write("file", "");
  EXPECT_THROW(PrepareFolder(folder / "file/x.exr"), Error);
  std::filesystem::create_directory(folder / "x.exr");
  EXPECT_THROW(PrepareFolder(folder / "x.exr"), Error);
}

TEST(Outputs, AReferenceOfAnotherSizeIsRefusedWithTheSizeToAskFor) {
  CheckReference(Gradient(), "ref.exr", 5, 3);
  try {
    CheckReference(Gradient(), "ref.exr", 640, 360);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--resolution 5x3"));
  }
}

TEST(Outputs, ErrorKindsHaveTheirExitCodes) {
  EXPECT_EQ(ExitCodeOf(ErrorKind::kInvalidInput), ExitCode::kUsage);
  EXPECT_EQ(ExitCodeOf(ErrorKind::kNotFound), ExitCode::kIo);
  EXPECT_EQ(ExitCodeOf(ErrorKind::kIo), ExitCode::kIo);
}

constexpr char kCsv[] =
    "method,seed,seconds,spp,iteration,relmse_estimated,rmse,mse,mae,relmse,relmse_trimmed\n"
    "path,0,1,4,0,0.5,,,,,\npath,0,2,8,0,0.25,,,,,\npath,1,1.1,4,0,0.6,,,,,\npath,1,2.2,8,0,0.2,,,,,\n"
    "\"sdtree:a=1,b=2\",0,1,4,0,0.4,,,,,\n\"sdtree:a=1,b=2\",0,2,8,0,0.1,,,,,\n";

TEST(Plot, IsDrawnWithoutADisplay) {
  TemporaryFolder folder;
  if (RunProgram({"/usr/bin/python3", "-c", "import matplotlib"}).code != 0)
    GTEST_SKIP() << "no matplotlib under /usr/bin/python3";
  const auto csv = folder.Write("e.csv", kCsv);
  ASSERT_TRUE(DrawErrorPlot(csv, folder / "e.png", "a title"));
  const Image plot = ReadImageFile(folder / "e.png");
  EXPECT_GT(plot.width, 400u);
  EXPECT_GT(plot.height, 200u);
}

TEST(Plot, WhatCannotBeDrawnIsSaidAndNothingMore) {
  TemporaryFolder folder;
  if (RunProgram({"/usr/bin/python3", "-c", "import matplotlib"}).code != 0)
    GTEST_SKIP() << "no matplotlib under /usr/bin/python3";
  testing::internal::CaptureStderr();
  EXPECT_FALSE(DrawErrorPlot(folder.Write("bad.csv", "a,b\n1,2\n"), folder / "e.png", ""));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("no plot"));
  EXPECT_FALSE(std::filesystem::exists(folder / "e.png"));
}

}  // namespace
}  // namespace lodestar
