// Real processes: whoever renders, in whatever order, the image is the same bits.
#include <nlohmann/json.hpp>

#include "tests/farm/support/farm_fixture.h"

namespace lodestar {
namespace {

class FarmTest : public FarmFixture, public testing::WithParamInterface<int> {};

TEST_P(FarmTest, GivesTheBitsOfOneProcess) {
  StartCoordinator();
  for (int i = 0; i < GetParam(); ++i) StartWorker();
  for (const char* method : {"path", "sdtree"}) {
    const auto spec = BoxJob(method, method == std::string("path") ? 16 : 32);
    const auto id = SubmitBox(spec, method);
    const auto status = Finish(id);
    ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
    EXPECT_EQ(status.width, 64u);
    EXPECT_TRUE(SameBits(client().GetImage(id), RenderHere(box_, spec).image)) << method;
    const auto report = nlohmann::json::parse(client().GetReport(id));
    EXPECT_FALSE(report.empty());
  }
}
INSTANTIATE_TEST_SUITE_P(Workers, FarmTest, testing::Values(1, 2, 5));

}  // namespace
}  // namespace lodestar
