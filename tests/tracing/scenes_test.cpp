// Every scene in scenes/: nothing of it is left out, it renders without health events under each method, and it is
// exposed so that its PNG can be looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "tests/support/render.h"

namespace lodestar {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(LODESTAR_SOURCE_DIR) / "scenes"))
    if (entry.path().extension() == ".pbrt") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

class Scenes : public testing::TestWithParam<std::string> {
 protected:
  // 32 pixels wide, in the scene's own proportions.
  test::Rendered Render(const std::string& method, std::map<std::string, std::string> options, uint64_t spp) const {
    const SceneDescription scene = ParsePbrtFile(fs::path(LODESTAR_SOURCE_DIR) / "scenes" / (GetParam() + ".pbrt"));
    EXPECT_TRUE(scene.left_out.empty());
    JobSpec job;
    job.method = method;
    job.options = std::move(options);
    job.resolution_x = 32;
    job.resolution_y = static_cast<uint32_t>(32 * scene.resolution_y / scene.resolution_x);
    job.budget.spp = spp;
    job.seed = 1;
    return test::Render(CompileJob(scene, job), job);
  }
};

TEST_P(Scenes, RenderWithoutHealthEvents) {
  for (const MethodEntry& method : Methods()) {
    // So that there is something to learn, and a race, in so few samples.
    std::map<std::string, std::string> options;
    if (method.name == "grid") options = {{"batch", "1"}, {"steps", "4"}};
    if (method.name == "focal") options = {{"initial-iterations", "2"}, {"narrowing-iterations", "2"}};
    if (method.name == "auto") options = {{"pilot", "1000"}};
    for (const char* nee : {"always", "never"}) {
      if (method.name != "auto") options["nee"] = nee;
      const HealthReport health = Render(method.name, options, 16).report.health;
      EXPECT_EQ(health.total(), 0u) << method.name << ", nee " << nee << ": "
                                    << (health.total() ? HealthEventName(health.first.event) : "");
      if (method.name == "auto") break;  // it takes none
    }
  }
}

TEST_P(Scenes, AreExposedForDisplay) {
  const Image image = Render("path", {{"nee", "always"}}, 64).image;
  double sum = 0;
  size_t black = 0;
  for (const auto& pixel : image.pixels) {
    sum += Luminance(pixel);
    black += Luminance(pixel) == 0;
  }
  const double mean = sum / static_cast<double>(image.size());
  if (GetParam() == "camera-obscura") {
    // Path tracing hardly ever meets the pinhole: that is the point of the scene.
    EXPECT_GT(black, image.size() * 9 / 10);
  } else {
    EXPECT_GT(mean, 0.08);
    EXPECT_LT(mean, 1);
    EXPECT_LT(black, image.size() / 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Own, Scenes, testing::ValuesIn(SceneNames()), [](const auto& info) {
  std::string name = info.param;
  name.erase(std::remove_if(name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }), name.end());
  return name;
});

}  // namespace
}  // namespace lodestar
