#include "worker/asset_cache.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "core/base/error.h"
#include "core/base/sha256_stream.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {
namespace fs = std::filesystem;

constexpr uint64_t kAmple = 1 << 20;

// What a coordinator would serve: one file of the text, under its hash.
struct Served {
  explicit Served(const TemporaryFolder& folder) : file(folder.Write("served", "a scene")), hash(Sha256OfFile(file)) {
    manifest.main = "scene.pbrt";
    manifest.files["scene.pbrt"] = {hash, fs::file_size(file)};
  }
  AssetCache::Fetch Fetch() {
    return [this](const ContentHash& wanted, const fs::path& to) {
      EXPECT_EQ(wanted, hash);
      ++fetches;
      fs::copy_file(file, to);  // refuses a name that is taken
    };
  }
  // Where a cache keeps it.
  fs::path In(const fs::path& cache) const { return cache / "content" / hash.hex.substr(0, 2) / hash.hex; }
  fs::path file;
  ContentHash hash;
  SceneManifest manifest;
  int fetches = 0;
};

TEST(AssetCache, FetchesAFileOnceForAllItsUses) {
  const TemporaryFolder folder;
  Served served(folder);
  AssetCache cache(folder / "cache", kAmple);
  const fs::path first = cache.Materialise(served.manifest, served.Fetch());
  const fs::path second = cache.Materialise(served.manifest, served.Fetch());
  EXPECT_NE(first, second);
  EXPECT_EQ(Sha256OfFile(first / "scene.pbrt"), served.hash);
  EXPECT_EQ(Sha256OfFile(second / "scene.pbrt"), served.hash);
  EXPECT_EQ(served.fetches, 1);
}

TEST(AssetCache, RemovesWhatKilledWorkersLeftAndNothingOfTheLiving) {
  const TemporaryFolder folder;
  Served served(folder);
  AssetCache living(folder / "cache", kAmple);
  const fs::path scene = living.Materialise(served.manifest, served.Fetch());
  const fs::path left = folder.Write("cache/workers/killed/1/scene.pbrt", "half a sc");
  AssetCache later(folder / "cache", kAmple);
  EXPECT_FALSE(fs::exists(left.parent_path().parent_path()));
  EXPECT_TRUE(fs::exists(scene / "scene.pbrt"));
  // The names of the two do not meet, though they are in one process.
  EXPECT_TRUE(fs::exists(later.Materialise(served.manifest, served.Fetch()) / "scene.pbrt"));
}

TEST(AssetCache, TakesItsScenesAlongAndLeavesTheContent) {
  const TemporaryFolder folder;
  Served served(folder);
  fs::path scene;
  {
    AssetCache cache(folder / "cache", kAmple);
    scene = cache.Materialise(served.manifest, served.Fetch());
  }
  EXPECT_FALSE(fs::exists(scene));
  AssetCache cache(folder / "cache", kAmple);
  EXPECT_TRUE(fs::exists(cache.Materialise(served.manifest, served.Fetch()) / "scene.pbrt"));
  EXPECT_EQ(served.fetches, 1);
}

TEST(AssetCache, FetchesDamagedContentAgain) {
  const TemporaryFolder folder;
  Served served(folder);
  AssetCache cache(folder / "cache", kAmple);
  cache.Materialise(served.manifest, served.Fetch());
  const fs::path content = served.In(folder / "cache");
  fs::remove(content);
  folder.Write(fs::relative(content, folder.path()), "another");
  const fs::path scene = cache.Materialise(served.manifest, served.Fetch());
  EXPECT_EQ(Sha256OfFile(scene / "scene.pbrt"), served.hash);
  EXPECT_EQ(served.fetches, 2);
}

TEST(AssetCache, ContentThatCannotBeOpenedIsThisMachinesFault) {
  const TemporaryFolder folder;
  Served served(folder);
  AssetCache cache(folder / "cache", kAmple);
  cache.Materialise(served.manifest, served.Fetch());
  const fs::path content = served.In(folder / "cache");
  fs::remove(content);
  ASSERT_EQ(mknod(content.c_str(), S_IFSOCK | 0600, 0), 0);  // which not even root can open
  try {
    cache.Materialise(served.manifest, served.Fetch());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kIo) << error.what();
    EXPECT_NE(std::string(error.what()).find(content.string()), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lodestar
