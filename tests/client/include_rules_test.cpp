// The include rules are only worth something if a broken one is found.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

Ran Check(const TemporaryFolder& folder) {
  return RunProgram({"/usr/bin/python3", LODESTAR_SOURCE_DIR "/cmake/check_includes.py", folder / ""});
}

TEST(IncludeRules, AllowedArrowsPass) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder / "core/film");
  folder.Write("core/film/film.cpp",
               "#include \"core/film/film.h\"\n#include \"core/math/vec.h\"\n#include <vector>\n");
  const Ran ran = Check(folder);
  EXPECT_EQ(ran.code, 0) << ran.out;
}

TEST(IncludeRules, AnArrowToTheRightIsFoundWithFileAndLine) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder / "core/math");
  folder.Write("core/math/vec.h", "#include <cmath>\n#include \"core/scene/scene.h\"\n");
  const Ran ran = Check(folder);
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.out, testing::HasSubstr("core/math/vec.h:2: core/math must not include core/scene"));
}

TEST(IncludeRules, LibrariesHaveOneOwner) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder / "coordinator/service");
  folder.Write("coordinator/service/a.cpp", "#include <embree3/rtcore.h>\n#include \"core/image/image.h\"\n");
  const Ran ran = Check(folder);
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.out, testing::HasSubstr("coordinator must not use <embree3/rtcore.h>"));
  EXPECT_THAT(ran.out, testing::HasSubstr("coordinator must not include core/image"));
}

TEST(IncludeRules, AFolderWithoutARuleIsFound) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder / "core/novel");
  folder.Write("core/novel/a.h", "#include <vector>\n");
  EXPECT_EQ(Check(folder).code, 2);
}

}  // namespace
}  // namespace lodestar
