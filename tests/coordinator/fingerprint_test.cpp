// Workers whose results would be other bits do not meet in one job.
#include "tests/coordinator/hand_worker.h"
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;

TEST_F(InProcessFarm, AJobStaysWithTheFingerprintThatBeganIt) {
  const auto spec = BoxJob("path", 8);
  const auto id = SubmitBox(spec);
  HandWorker other(server->address(), box, spec, "other", "another Embree");
  {
    HandWorker first(server->address(), box, spec, "first");
    const auto survey = first.Lease();
    ASSERT_TRUE(survey && !survey->render);
    first.Survey(*survey);
    const auto unit = first.Lease();
    ASSERT_TRUE(unit && unit->render);
    EXPECT_FALSE(other.Lease(milliseconds(100))) << "the job has begun on another fingerprint";
    const auto more = first.Lease();
    ASSERT_TRUE(more && more->render) << "there was work to be had";
    first.Render(*unit);
    first.Render(*more);
  }
  // The next job is anyone's.
  const auto next = SubmitBox(spec);
  const auto survey = other.Lease();
  ASSERT_TRUE(survey && !survey->render);
  EXPECT_EQ(survey->job, next);
  other.Survey(*survey);
  const auto unit = other.Lease();
  ASSERT_TRUE(unit && unit->render);
  EXPECT_EQ(unit->job, next);
  EXPECT_NE(unit->job, id);
}

}  // namespace
}  // namespace lodestar
