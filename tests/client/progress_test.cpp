#include "client/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lodestar {
namespace {

using testing::HasSubstr;
using testing::Not;

JobProgress Half() {
  JobProgress progress;
  progress.iteration = 3;
  progress.passes = 128;
  progress.seconds = 10;
  progress.relmse_estimated = 0.01234;
  progress.fraction = 0.5;
  progress.seconds_left = 34;
  progress.rays = 32100000;
  return progress;
}

std::string Written(std::FILE* file) {
  std::string text(static_cast<size_t>(std::ftell(file)), '\0');
  std::rewind(file);
  text.resize(std::fread(text.data(), 1, text.size(), file));
  return text;
}

TEST(Progress, OneLineSaysEverything) {
  const std::string line = ProgressText(Half(), 120);
  for (const char* part : {"50%", "iteration 3", "128 spp", "error 0.01234", "3.21 Mrays/s", "left 0:34", "[####"})
    EXPECT_THAT(line, HasSubstr(part));
}

TEST(Progress, ALineNeverWrapsATerminal) {
  for (const int width : {0, 10, 40, 80, 200}) EXPECT_LE(static_cast<int>(ProgressText(Half(), width).size()), width);
}

TEST(Progress, WhatIsUnknownIsNotInvented) {
  const std::string line = ProgressText(JobProgress(), 120);
  EXPECT_THAT(line, HasSubstr("error -"));
  EXPECT_THAT(line, HasSubstr("left -:--"));
  EXPECT_THAT(line, Not(HasSubstr("rays/s")));
}

TEST(Progress, AFileGetsPlainLinesNowAndThen) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  ManualClock clock;
  {
    ProgressLine line(false, file, clock);
    for (int i = 0; i < 60; ++i) {
      line.Update(Half());
      clock.Advance(std::chrono::seconds(1));
    }
  }
  const std::string text = Written(file);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 12);  // at 0, 5, ... 55 s
  EXPECT_THAT(text, Not(HasSubstr("\r")));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  std::fclose(file);
}

TEST(Progress, QuietSaysNothing) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  {
    ProgressLine line(true, file);
    line.Update(Half());
  }
  EXPECT_EQ(std::ftell(file), 0);
  std::fclose(file);
}

}  // namespace
}  // namespace lodestar
