#include "client/interim_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using Picture = InterimPictures::Picture;

Picture Grey(float value) {
  Picture picture;
  picture.image.width = 4;
  picture.image.height = 3;
  picture.image.pixels.assign(12, Rgb(value));
  picture.image.variance.assign(12, 0);
  return picture;
}

TEST(InterimPictures, ComeRarerAsTheRunGrows) {
  ProgressLine progress(true);
  InterimPictures pictures(OutputPaths::For("never-written.exr"), progress);
  std::vector<double> at;
  for (int seconds = 0; seconds <= 3600; ++seconds) {
    pictures.Update(seconds, [&]() -> std::optional<Picture> {
      at.push_back(seconds);
      return std::nullopt;
    });
  }
  ASSERT_GT(at.size(), 8u);
  EXPECT_THAT(std::vector<double>(at.begin(), at.begin() + 8),
              testing::ElementsAre(10, 40, 70, 100, 130, 160, 192, 231));
  EXPECT_EQ(at.back() - at[at.size() - 2], 300);
  EXPECT_FALSE(std::filesystem::exists("never-written.exr")) << "there was no picture";
}

TEST(InterimPictures, AreTheImageAndItsPngOfTheLastUpdate) {
  TemporaryFolder folder;
  ProgressLine progress(true);
  InterimPictures pictures(OutputPaths::For(folder / "a.exr"), progress);
  for (const float seconds : {9.0f, 10.0f, 39.0f, 40.0f, 41.0f})
    pictures.Update(seconds, [&] { return Grey(seconds); });
  EXPECT_EQ(ReadImageFile(folder / "a.exr").pixels.front(), Rgb(40));
  EXPECT_EQ(ReadImageFile(folder / "a.png").width, 4u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(InterimPictures, SayOnceThatTheyCannotBeWrittenAndTryOn) {
  TemporaryFolder folder;
  ProgressLine progress(true);
  InterimPictures pictures(OutputPaths::For(folder / "later/a.exr"), progress);
  testing::internal::CaptureStderr();
  for (const double seconds : {10, 100}) pictures.Update(seconds, [] { return Grey(1); });
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, testing::HasSubstr("later/a.exr"));
  EXPECT_EQ(said.find("no picture so far"), said.rfind("no picture so far")) << said;
  std::filesystem::create_directory(folder / "later");
  pictures.Update(200, [] { return Grey(1); });
  EXPECT_EQ(ReadImageFile(folder / "later/a.exr").width, 4u);
}

}  // namespace
}  // namespace lodestar
