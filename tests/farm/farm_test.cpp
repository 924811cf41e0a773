// Real processes: whoever renders, in whatever order, the image is the same bits.
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/farm/support/box.h"
#include "tests/farm/support/farm_fixture.h"

namespace lodestar {
namespace {

class FarmTest : public FarmFixture {};
struct Crew {
  int workers, threads;  // of each
};
class FarmOfWorkers : public FarmFixture, public testing::WithParamInterface<Crew> {};

TEST_P(FarmOfWorkers, GivesTheBitsOfOneProcess) {
  StartCoordinator();
  for (int i = 0; i < GetParam().workers; ++i) StartWorker({}, GetParam().threads);
  for (const std::string method : {"path", "sdtree", "focal", "grid", "sdtree+focal", "auto"}) {
    auto spec = BoxJob(method, method == "path" ? 16 : 32);
    if (method == "grid") spec.options = {{"batch", "2"}, {"steps", "4"}};
    if (method == "focal") spec.options = {{"initial-iterations", "2"}, {"narrowing-iterations", "2"}};
    if (method == "sdtree+focal") spec.options = {{"training", "4"}};
    if (method == "auto") spec.options["pilot"] = "1000";  // so that there is a race in so small a picture
    const auto id = SubmitBox(spec, method);
    const auto status = Finish(id);
    ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
    EXPECT_EQ(status.width, 64u);
    const auto image = client().GetImage(id);
    const auto expected = RenderHere(box_, spec);
    EXPECT_TRUE(SameBits(image, expected.image)) << method;
    const auto report = nlohmann::json::parse(client().GetReport(id));
    EXPECT_EQ(report["result"]["state_sha256"], expected.report.state_hash.hex) << method;
    EXPECT_EQ(report["result"]["image_sha256"], expected.report.image_hash.hex) << method;
    EXPECT_EQ(ImageHash(image), expected.report.image_hash) << method;
    const std::string& choice = expected.report.choice;
    EXPECT_EQ(report["result"].value("choice", ""), choice) << method;
    if (method == "auto") {
      EXPECT_NE(choice.find("times as efficient"), std::string::npos) << choice;
      EXPECT_EQ(std::count(status.log.begin(), status.log.end(), "chose " + choice), 1)
          << choice << "; " << testing::PrintToString(status.log);
    }
    if (method == "path") {
      EXPECT_THROW(client().GetGuide(id), Error) << "it learns nothing";
    } else {
      const GuideFile guide = client().GetGuide(id);
      EXPECT_EQ(Sha256(guide.state), expected.report.state_hash) << method;
      EXPECT_EQ(guide.job.method, method);
      EXPECT_EQ(guide.iterations, static_cast<uint32_t>(expected.report.training_iterations)) << method;
    }
  }
}

// Lobes that the product looks up in its table; the box has none.
TEST_F(FarmTest, AProductOfGlossyLobesGivesTheBitsOfOneProcess) {
  StartCoordinator();
  StartWorker();
  StartWorker({}, 2);
  const auto file = folder_.path() / "scene" / "glossy.pbrt";
  std::ofstream(file) << std::string(kBoxScene) + R"(
AttributeBegin
  Translate 0.5 1.2 -0.4
  Material "conductor" "float roughness" [ 0.2 ]
  Shape "sphere" "float radius" [ 0.3 ]
AttributeEnd
)";
  const SceneBundle glossy = BundleScene({file.string(), (folder_.path() / "scene" / "block.pbrt").string()});
  JobSubmission submission;
  submission.name = "glossy";
  submission.spec = BoxJob("sdtree", 32);
  submission.spec.options = {{"product", "on"}};
  submission.scene = client().Upload(glossy);
  const auto id = client().SubmitJob(submission);
  const auto status = Finish(id);
  ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
  ExpectBits(client(), id, RenderHere(glossy, submission.spec));
}

TEST_F(FarmTest, ALenientJobRendersAndListsWhatItLeftOut) {
  StartCoordinator();
  StartWorker();
  StartWorker();
  const auto file = folder_.path() / "scene" / "odd.pbrt";
  std::ofstream(file) << std::string(kBoxScene) + "Shape \"curve\"\n";
  JobSubmission submission;
  submission.name = "odd";
  submission.spec = BoxJob("path", 4);
  submission.scene = client().Upload(BundleScene({file.string(), (folder_.path() / "scene" / "block.pbrt").string()}));
  const auto strict = Finish(client().SubmitJob(submission));
  EXPECT_EQ(strict.phase, JobPhase::kFailed);
  EXPECT_NE(strict.error.find("curve"), std::string::npos) << strict.error;
  submission.client_token.clear();
  submission.spec.lenient = true;
  const auto id = client().SubmitJob(submission);
  const auto status = Finish(id);
  ASSERT_EQ(status.phase, JobPhase::kDone) << status.error;
  EXPECT_TRUE(SameBits(client().GetImage(id), RenderHere(box_, BoxJob("path", 4)).image))
      << "what is left must be the box";
  const auto report = nlohmann::json::parse(client().GetReport(id));
  ASSERT_EQ(report["scene"]["left_out"].size(), 1u);
  EXPECT_TRUE(report["scene"]["left_out"][0].get<std::string>().starts_with("odd.pbrt:"))
      << report["scene"]["left_out"] << ": no paths of the worker's";
}
INSTANTIATE_TEST_SUITE_P(Of, FarmOfWorkers, testing::Values(Crew{1, 1}, Crew{2, 2}, Crew{5, 1}), [](const auto& info) {
  return std::to_string(info.param.workers) + "WorkersOf" + std::to_string(info.param.threads) +
         (info.param.threads > 1 ? "Threads" : "Thread");
});

}  // namespace
}  // namespace lodestar
