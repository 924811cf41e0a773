#include <gtest/gtest.h>

#include <fstream>

#include "coordinator/blob_store.h"
#include "coordinator/checkpoint.h"
#include "core/base/error.h"
#include "rpc/status.h"
#include "tests/farm/support/process.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

struct StoreTest : testing::Test {
  TemporaryFolder folder;
  uint64_t free = uint64_t{1} << 40;
  int64_t now = 1000000000;
  BlobStore::Options BlobOptions() {
    BlobStore::Options options;
    options.free_bytes = [this] { return free; };
    options.now_unix_ms = [this] { return now; };
    return options;
  }
  StoredJob NewJob(const std::string& token, const ContentHash& description) {
    StoredJob job;
    job.client_token = token;
    job.name = "name of " + token;
    job.scene_path = "/scenes/" + token + ".pbrt";
    job.reference.hex = std::string(64, '5');
    job.priority = 5;
    job.submitted_unix_ms = 42;
    job.description = description;
    return job;
  }
  ErrorKind KindOf(const std::function<void()>& f) {
    try {
      f();
    } catch (const Error& error) {
      last = error.what();
      return error.kind();
    }
    ADD_FAILURE() << "did not throw";
    return ErrorKind::kIo;
  }
  std::string last;
};

TEST_F(StoreTest, JobsSurviveReopening) {
  StoredJob job;
  {
    JobStore store(folder.path());
    EXPECT_EQ(store.epoch(), 1u);
    BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
    const auto description = blobs.Put("description");
    job = store.Insert(NewJob("a", description), {description});
    EXPECT_EQ(store.Insert(NewJob("a", description), {description}).number, job.number)
        << "the same token is the same job";
    EXPECT_EQ(store.Jobs().size(), 1u);
    job.phase = JobPhase::kRunning;
    job.survey = std::string("\0survey", 7);
    job.log = "one\ntwo";
    job.progress = std::string("\0\0p", 3);
    store.Update(job);
  }
  JobStore store(folder.path());
  EXPECT_EQ(store.epoch(), 2u);
  const auto jobs = store.Jobs();
  ASSERT_EQ(jobs.size(), 1u);
  EXPECT_EQ(jobs[0].id().value, "job-" + std::to_string(job.number));
  EXPECT_EQ(jobs[0].name, "name of a");
  EXPECT_EQ(jobs[0].scene_path, "/scenes/a.pbrt");
  EXPECT_EQ(jobs[0].reference.hex, std::string(64, '5'));
  EXPECT_EQ(jobs[0].priority, 5);
  EXPECT_EQ(jobs[0].phase, JobPhase::kRunning);
  EXPECT_EQ(jobs[0].survey, job.survey);
  EXPECT_EQ(jobs[0].log, job.log);
  EXPECT_EQ(jobs[0].progress, job.progress);
  BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
  EXPECT_EQ(blobs.Read(jobs[0].description), "description");
}

TEST_F(StoreTest, MissingAssetsAreNamedAndNothingIsStored) {
  JobStore store(folder.path());
  const ContentHash missing{std::string(64, '7')};
  EXPECT_EQ(KindOf([&] { store.Insert(NewJob("a", missing), {missing}); }), ErrorKind::kConflict);
  EXPECT_NE(last.find(missing.hex), std::string::npos);
  EXPECT_TRUE(store.Jobs().empty());
}

TEST_F(StoreTest, AnotherVersionIsRefused) {
  { JobStore store(folder.path()); }
  for (const int version : {JobStore::kSchemaVersion - 1, 99}) {
    const std::string number = std::to_string(version);
    Database(folder.path() / "jobs.sqlite")
        .Execute(("UPDATE meta SET value = " + number + " WHERE key = 'schema'").c_str());
    EXPECT_EQ(KindOf([&] { JobStore store(folder.path()); }), ErrorKind::kConflict);
    EXPECT_NE(last.find("schema version " + number), std::string::npos) << last;
  }
  std::ofstream(folder.path() / "jobs.sqlite")
      << "this is no database, but it is long enough to be taken for one by its size alone";
  EXPECT_EQ(KindOf([&] { JobStore store(folder.path()); }), ErrorKind::kCorrupt);
}

TEST_F(StoreTest, AStoreHasOneCoordinator) {
  {
    JobStore first(folder.path());
    EXPECT_EQ(KindOf([&] { JobStore second(folder.path()); }), ErrorKind::kConflict);
    EXPECT_NE(last.find(folder.path().string()), std::string::npos) << last;
    first.AddBlob(Sha256("x"), 1, now);  // not fenced by the one that was refused
  }
  EXPECT_EQ(JobStore(folder.path()).epoch(), 2u);
}

TEST_F(StoreTest, AnOldEpochIsFenced) {
  int fenced = 0;
  JobStore old(folder.path(), [&](const std::string&) { ++fenced; });
  BlobStore blobs(folder.path() / "blobs", old, BlobOptions());
  const auto description = blobs.Put("x");
  std::filesystem::remove(folder.path() / "lock");  // another machine's coordinator sees no lock of this one's
  JobStore young(folder.path());
  EXPECT_EQ(KindOf([&] { old.Insert(NewJob("a", description), {description}); }), ErrorKind::kConflict);
  EXPECT_EQ(fenced, 1);
  EXPECT_EQ(KindOf([&] { old.HaveBlobs({description}, now); }), ErrorKind::kConflict);
  EXPECT_EQ(fenced, 2) << "not only where a job is written";
  EXPECT_EQ(young.Insert(NewJob("a", description), {description}).number, 1);
}

TEST_F(StoreTest, BlobsNobodyNeedsAreCollectedAfterTheirGrace) {
  JobStore store(folder.path());
  BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
  const auto needed = blobs.Put("needed"), idle = blobs.Put("idle"), description = blobs.Put("description"),
             used = blobs.Put("used"), guide = blobs.Put("guide");
  auto job = store.Insert(NewJob("a", description), {description, needed});
  EXPECT_EQ(blobs.Collect(), 0u) << "an upload may still be on its way to its job";
  now += 9 * 60 * 1000;
  EXPECT_EQ(blobs.Have({used, guide}).size(), 2u);
  now += 2 * 60 * 1000;
  EXPECT_EQ(blobs.Collect(), 1u);
  EXPECT_THROW(blobs.Read(idle), Error);
  EXPECT_EQ(blobs.Read(needed), "needed");
  EXPECT_EQ(blobs.Read(used), "used");
  job.phase = JobPhase::kDone;
  job.image = used;
  job.guide = guide;
  store.Update(job);
  now += 60 * 60 * 1000;
  EXPECT_EQ(blobs.Collect(), 1u) << "the scene of an ended job; its image, guide and description stay";
  EXPECT_EQ(blobs.Read(used), "used");
  EXPECT_EQ(blobs.Read(guide), "guide");
  EXPECT_EQ(blobs.Read(description), "description");
}

TEST_F(StoreTest, ACheckpointGoesWhenItHasASuccessor) {
  JobStore store(folder.path());
  BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
  const auto description = blobs.Put("d"), first = blobs.Put("first"), second = blobs.Put("second");
  auto job = store.Insert(NewJob("a", description), {description});
  job.checkpoint = first;
  store.Update(job);
  blobs.Drop(first);
  EXPECT_EQ(blobs.Read(first), "first") << "it is needed";
  job.checkpoint = second;
  store.Update(job);
  blobs.Drop(first);
  EXPECT_THROW(blobs.Read(first), Error);
  EXPECT_EQ(blobs.Read(second), "second");
}

TEST_F(StoreTest, AFullDiskIsForeseen) {
  JobStore store(folder.path());
  auto options = BlobOptions();
  options.reserve_bytes = 1 << 20;
  BlobStore blobs(folder.path() / "blobs", store, options);
  blobs.Put("small");
  free = (1 << 20) + 100;
  blobs.Put("still fits");
  EXPECT_THROW(blobs.Put(std::string(200, 'x')), ExhaustedError);
  EXPECT_THROW(blobs.NewWriter(Sha256("y"), 1 << 30), ExhaustedError);
  using enum BlobStore::For;
  struct Case {
    BlobStore::For purpose;
    uint64_t leaves;  // KiB of a reserve of 1024
  };
  for (const Case& c : {Case{kClient, 1024}, Case{kCheckpoint, 512}, Case{kResult, 256}}) {
    SCOPED_TRACE(c.leaves);
    free = (c.leaves << 10) + 100;
    EXPECT_NO_THROW(blobs.CheckSpace(100, c.purpose));
    EXPECT_THROW(blobs.CheckSpace(101, c.purpose), ExhaustedError);
    EXPECT_THROW(blobs.Put("more than" + std::string(100, 'x'), c.purpose), ExhaustedError);
    blobs.Put("fits, " + std::to_string(c.leaves), c.purpose);
    free = 0;
    EXPECT_THROW(blobs.CheckSpace(0, c.purpose), ExhaustedError);
  }
  EXPECT_EQ(blobs.Put("small"), Sha256("small")) << "what is there needs no space";
}

TEST_F(StoreTest, UploadsUnderWayAreCounted) {
  JobStore store(folder.path());
  BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
  const uint64_t gib = uint64_t{1} << 30;
  free = 3 * gib;
  auto first = blobs.NewWriter(Sha256("first"), 2 * gib);
  EXPECT_EQ(KindOf([&] { blobs.NewWriter(Sha256("second"), 2 * gib); }), ErrorKind::kIo);
  EXPECT_NE(last.find("2048 MiB of them for uploads"), std::string::npos) << last;
  EXPECT_THROW(blobs.CheckSpace(2 * gib), ExhaustedError);
  EXPECT_NO_THROW(blobs.CheckSpace(2 * gib, BlobStore::For::kCheckpoint)) << "a job that runs does not wait for them";
  // What is written is no longer free, and counts once.
  const std::string part(1 << 20, 'x');
  first->Append(part);
  free -= part.size();
  const uint64_t left = gib - (uint64_t{256} << 20);  // without the reserve
  EXPECT_NO_THROW(blobs.CheckSpace(left));
  EXPECT_THROW(blobs.CheckSpace(left + 1), ExhaustedError);
  // An upload that ends gives back what it did not write.
  first.reset();
  free += part.size();
  EXPECT_NO_THROW(blobs.NewWriter(Sha256("second"), 2 * gib));
  auto whole = blobs.NewWriter(Sha256("whole"), 5);
  whole->Append("whole");
  whole->Commit();
  whole.reset();
  EXPECT_NO_THROW(blobs.CheckSpace(2 * gib + left));
}

TEST_F(StoreTest, DamagedUploadsLeaveNothing) {
  JobStore store(folder.path());
  BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
  const auto hash = Sha256("content");
  EXPECT_EQ(KindOf([&] {
              auto writer = blobs.NewWriter(hash, 7);
              writer->Append("c0ntent");
              writer->Commit();
            }),
            ErrorKind::kCorrupt);
  EXPECT_EQ(KindOf([&] { blobs.NewWriter(hash, 7)->Append("content and more"); }), ErrorKind::kInvalidInput);
  EXPECT_EQ(KindOf([&] { blobs.NewWriter({"../../x"}, 7); }), ErrorKind::kInvalidInput);
  EXPECT_TRUE(blobs.Have({hash}).empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "blobs" / "temporary"));
  auto writer = blobs.NewWriter(hash, 7);
  writer->Append("con");
  writer->Append("tent");
  writer->Commit();
  EXPECT_EQ(blobs.Read(hash), "content");
}

TEST_F(StoreTest, OrphansOfACrashGoAtTheNextStart) {
  const auto hash = Sha256("orphan");
  const auto file = folder.path() / "blobs" / hash.hex.substr(0, 2) / hash.hex;
  {
    JobStore store(folder.path());
    BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << "orphan";  // renamed, and then the crash
    std::ofstream(folder.path() / "blobs" / "temporary" / "17") << "half";
  }
  JobStore store(folder.path());
  BlobStore blobs(folder.path() / "blobs", store, BlobOptions());
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "blobs" / "temporary"));
}

TEST(Checkpoint, SurvivesAndRefusesOtherVersions) {
  JobCheckpoint c;
  c.loop = std::string("\0loop", 5);
  c.round = {1, 2, 3, 4, 5, false};
  c.state = {std::string(64, 'c')};
  c.nodes = {{0, 1}, {2, 1}};
  c.merged = "both";
  auto bytes = c.Serialize();
  const auto back = JobCheckpoint::Parse(bytes);
  EXPECT_EQ(back.loop, c.loop);
  EXPECT_EQ(back.round, c.round);
  EXPECT_EQ(back.state, c.state);
  EXPECT_EQ(back.nodes, c.nodes);
  EXPECT_EQ(back.merged, c.merged);
  for (size_t cut = 0; cut < bytes.size(); ++cut) EXPECT_THROW(JobCheckpoint::Parse(bytes.substr(0, cut)), Error);
  bytes[4] = 9;
  try {
    JobCheckpoint::Parse(bytes);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kConflict);
  }
}

}  // namespace
}  // namespace lodestar
