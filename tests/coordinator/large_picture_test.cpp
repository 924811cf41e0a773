// A picture that this coordinator has no memory for is refused before any is taken, wherever its size comes from.
#include "rpc/status.h"
#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

struct LargePicture : InProcessFarm {
  void RestartWith(uint64_t memory_bytes) {
    End();
    options.memory_bytes = memory_bytes;
    Start();
  }
  static void ExpectReason(const std::string& error, const std::string& size, const std::string& mib) {
    for (const std::string& part : {size, mib + " MiB", std::string("--resolution")})
      EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
  }
};

TEST_F(LargePicture, IsRefusedAtSubmission) {
  RestartWith(uint64_t{64} << 20);
  auto spec = BoxJob("path", 4);
  spec.resolution_x = spec.resolution_y = 8192;
  try {
    SubmitBox(spec);
    FAIL() << "taken";
  } catch (const ExhaustedError& error) {
    ExpectReason(error.what(), "8192x8192", "64");
    ExpectReason(error.what(), "8192x8192", "2048");
  }
  EXPECT_TRUE(client->ListJobs().empty());
  spec.resolution_x = spec.resolution_y = 1024;  // 32 MiB: one film
  SubmitBox(spec);
  spec.method = "sdtree";  // several
  EXPECT_THROW(SubmitBox(spec), ExhaustedError);
}

TEST_F(LargePicture, OfTheScenesOwnSizeEndsItsJob) {
  const auto spec = BoxJob("path", 4);
  RestartWith(64 * 48 * 32);  // a film of the box takes twice what it may
  const auto id = SubmitBox(spec);
  HandWorker worker(server->address(), box, spec);
  const auto unit = worker.Lease();
  ASSERT_TRUE(unit && !unit->render);
  worker.Survey(*unit);
  const auto status = client->Watch(id, {});
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  ExpectReason(status.error, "64x48", "0");
}

TEST_F(LargePicture, IsNotTriedAgainAtARestartWithLessMemory) {
  const auto spec = BoxJob("path", 4);
  const auto id = SubmitBox(spec);
  {
    HandWorker worker(server->address(), box, spec);
    const auto unit = worker.Lease();
    ASSERT_TRUE(unit && !unit->render);
    worker.Survey(*unit);
    ASSERT_TRUE(worker.Lease());
  }
  RestartWith(64 * 48 * 32);
  const auto status = client->Watch(id, {});
  EXPECT_EQ(status.phase, JobPhase::kFailed);
  ExpectReason(status.error, "64x48", "0");
}

}  // namespace
}  // namespace lodestar
