// Guiding states in files, what `inspect --guide` draws of them, and the channels of `render --aov`: the built program
// on small scenes.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "client/guide_inspection.h"
#include "client/guide_pictures.h"
#include "client/outputs.h"
#include "core/learning/guide_file.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<std::string> kNoPlot = {"LODESTAR_PLOT=/nonexistent"};

// Renders the tiny scene of run_program.h, 31 spp, with its state.
class Inspect : public testing::Test {
 protected:
  Inspect() : scene_(folder_.Write("tiny.pbrt", kTinyScene)), state_(folder_ / "a.lguide") {}

  nlohmann::json Render(std::vector<std::string> more) {
    std::vector<std::string> words = {"render",  scene_, "--resolution", "32x24",           "--spp",   "63",
                                      "--state", state_, "-o",           folder_ / "a.exr", "--quiet", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    if (std::ranges::find(more, "--method") == more.end()) words.insert(words.end(), {"--method", "sdtree"});
    const Ran ran = RunLodestar(words, kNoPlot);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return nlohmann::json::parse(ran.out, nullptr, false);
  }
  Ran Run(std::vector<std::string> words) {
    words.insert(words.begin(), {"inspect", "--guide", state_});
    return RunLodestar(words);
  }
  nlohmann::json Json(std::vector<std::string> words) {
    words.push_back("--json");
    const Ran ran = Run(words);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return nlohmann::json::parse(ran.out, nullptr, false);
  }

  // Every picture exists, has the size it is said to have, and is not black.
  static std::map<std::string, nlohmann::json> Pictures(const nlohmann::json& json) {
    std::map<std::string, nlohmann::json> pictures;
    for (const auto& picture : json["pictures"]) {
      const Image image = ReadImageFile(picture["file"].get<std::string>());
      EXPECT_GT(picture["max"].get<double>(), 0) << picture["name"];
      EXPECT_EQ(image.width, picture["size"][0].get<uint32_t>());
      EXPECT_EQ(image.height, picture["size"][1].get<uint32_t>());
      pictures[picture["name"].get<std::string>()] = picture;
    }
    return pictures;
  }

  // Paths of both techniques, and the light they find: by either as much, but for the noise of a guide without the
  // BSDF.
  static void ExpectPaths(std::map<std::string, nlohmann::json>& pictures) {
    for (const std::string axis : {"x", "y", "z"}) {
      for (const std::string name : {"rays-bsdf-", "rays-guide-", "rays-bsdf-light-", "rays-guide-light-"})
        ASSERT_TRUE(pictures.contains(name + axis)) << name + axis;
      const double bsdf = pictures["rays-bsdf-light-" + axis]["mean"].get<double>();
      EXPECT_NEAR(pictures["rays-guide-light-" + axis]["mean"].get<double>(), bsdf, 0.35 * bsdf) << axis;
    }
  }

  TemporaryFolder folder_;
  std::string scene_, state_;
};

TEST_F(Inspect, TheFileHoldsTheStateTheRunEndedWith) {
  const auto report = Render({});
  EXPECT_EQ(report["files"]["state"], state_);
  const GuideFile file = GuideFile::Read(state_);
  EXPECT_EQ(Sha256(file.state).hex, report["result"]["state_sha256"].get<std::string>());
  EXPECT_EQ(file.iterations, report["result"]["training_iterations"].get<uint32_t>());
  // Where the budget ends within training, that iteration has made no state.
  const auto cut = Render({"--training-iterations", "20"});
  EXPECT_EQ(cut["result"]["training_iterations"], cut["result"]["iterations"]);
  EXPECT_EQ(GuideFile::Read(state_).iterations + 1, cut["result"]["iterations"].get<uint32_t>());
  EXPECT_EQ(file.survey.scene_hash, report["scene"]["hash"].get<std::string>());
  EXPECT_EQ(file.Serialize(), GuideFile::Parse(file.Serialize(), "copy").Serialize());
  // To save the state changes nothing.
  const Ran without = RunLodestar({"render", scene_, "--method", "sdtree", "--resolution", "32x24", "--spp", "63", "-o",
                                   folder_ / "b.exr", "--json"},
                                  kNoPlot);
  EXPECT_EQ(nlohmann::json::parse(without.out)["result"]["image_sha256"], report["result"]["image_sha256"]);
}

TEST_F(Inspect, TreesRemadeFromTheRecordsAreTheStatesOwn) {
  for (const std::string reconstruction : {"none", "native"}) {
    Render({"--reconstruction", reconstruction});
    const GuideFile file = GuideFile::Read(state_);
    const auto state = SdTreeState::Parse(file.state);
    int compared = 0;
    for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 1}, Vec3{-2, 0, 1}}) {
      const SdTree& tree = state->tree();
      const uint32_t leaf = tree.LeafAt(p);
      const std::string same = reconstruction == "none" ? "rebuilt" : "native";
      for (const RemadeTree& remade : RemakeTrees(file, p)) {
        const bool equal = remade.tree.nodes.size() == tree.leaf(leaf).node_count &&
                           std::memcmp(remade.tree.nodes.data(), tree.Tree(leaf),
                                       remade.tree.nodes.size() * sizeof(DirectionalNode)) == 0;
        EXPECT_TRUE(remade.name != "native" || reconstruction == "native") << "no halves to compare";
        if (remade.name == same) {
          EXPECT_TRUE(equal) << reconstruction;
          ++compared;
        } else if (remade.name == "rebuilt") {
          EXPECT_FALSE(equal) << "reconstruction must show";
        }
      }
    }
    EXPECT_GT(compared, 0) << reconstruction;
  }
}

TEST_F(Inspect, TheTableCountsWhatTheStateHolds) {
  Render({});
  const auto json = Json({});
  const auto state = SdTreeState::Parse(GuideFile::Read(state_).state);
  EXPECT_EQ(json["method"], "sdtree");
  EXPECT_EQ(json["state"]["spatial"]["leaves"], state->tree().leaf_count());
  EXPECT_EQ(json["state"]["directional"]["nodes"], state->tree().node_count());
  uint64_t trees = 0;
  for (const auto& count : json["state"]["directional"]["histogram"]) trees += count.get<uint64_t>();
  EXPECT_EQ(trees, state->tree().leaf_count());
  EXPECT_GT(json["state"]["records"]["total"].get<double>(), 1000);
  EXPECT_EQ(json["scene_checked"], false);
  EXPECT_TRUE(json["pictures"].empty());
  EXPECT_THAT(Run({}).out, AllOf(HasSubstr("spatial leaves"), HasSubstr("BSDF fraction"), HasSubstr("not checked")));
}

TEST_F(Inspect, PicturesAtAPixelIntegrateToOne) {
  Render({"--product", "on", "--reconstruction", "native"});
  const auto json = Json({scene_, "--pixel", "16,20", "-o", folder_ / "p"});
  EXPECT_EQ(json["scene_checked"], true);
  EXPECT_NEAR(json["point"]["p"][1].get<double>(), 0, 1e-4);  // the floor
  EXPECT_NEAR(json["point"]["normal"][1].get<double>(), 1, 1e-4);
  auto pictures = Pictures(json);
  for (const char* name : {"dtree", "dtree-latlong", "dtree-rebuilt", "dtree-native", "dtree-dense", "lobes", "product",
                           "product-exact", "product-latlong", "bsdf", "bsdf-latlong"}) {
    ASSERT_TRUE(pictures.contains(name)) << name;
    EXPECT_NEAR(pictures[name]["integral"].get<double>(), 1, 0.02) << name;
  }
  EXPECT_NEAR(pictures["dtree"]["integral"].get<double>(), 1, 1e-4);
  // The light is above: what reaches the floor is brighter than the mean somewhere, and a diffuse lobe is 1/pi at most.
  EXPECT_GT(pictures["dtree"]["max"].get<double>(), 4 * 0.0796);
  EXPECT_NEAR(pictures["bsdf"]["max"].get<double>(), 0.3183, 1e-3);
  for (const char* name : {"flux-x", "flux-y", "flux-z", "records-x", "records-y", "records-z"})
    ASSERT_TRUE(pictures.contains(name)) << name;
  EXPECT_GT(pictures["flux-y"]["max"].get<double>(), 0);
  ExpectPaths(pictures);
  // All paths begin in one place, and of those of a diffuse BSDF none is lost; none passes a pixel more than thrice.
  EXPECT_GT(pictures["rays-bsdf-y"]["max"].get<double>(), 1000);
  EXPECT_LE(pictures["rays-guide-y"]["max"].get<double>(), 3 * 4096);
}

TEST_F(Inspect, APointNeedsNoScene) {
  Render({});
  auto pictures = Pictures(
      Json({"--at", "0.5,0,0.5", "--normal", "0,1,0", "--wo", "1,1,0", "--roughness", "0.2", "-o", folder_ / "p"}));
  ASSERT_TRUE(pictures.contains("product"));
  EXPECT_NEAR(pictures["product"]["integral"].get<double>(), 1, 0.02);
  EXPECT_GT(pictures["lobes"]["max"].get<double>(), 1);  // glossy
  EXPECT_FALSE(pictures.contains("bsdf"));
}

TEST_F(Inspect, ASurfaceIsFoundUnderAPoint) {
  // A guide without the BSDF has outliers: with one seed in twenty its light is off by more than ExpectPaths allows.
  Render({"--seed", "2"});
  // Above the floor, whose own BSDF counts: diffuse.
  const auto json = Json({scene_, "--at", "0.5,0.3,0.5", "--normal", "0,1,0", "-o", folder_ / "p"});
  EXPECT_NEAR(json["point"]["p"][1].get<double>(), 0, 1e-4);
  EXPECT_NEAR(json["point"]["normal"][1].get<double>(), 1, 1e-4);
  auto pictures = Pictures(json);
  ASSERT_TRUE(pictures.contains("bsdf"));
  EXPECT_NEAR(pictures["bsdf"]["max"].get<double>(), 0.3183, 1e-3);
  ExpectPaths(pictures);
  // On it, and from below.
  EXPECT_NEAR(Json({scene_, "--at", "0.5,0,0.5", "--normal", "0,1,0"})["point"]["p"][1].get<double>(), 0, 1e-4);
  const Ran nothing = Run({scene_, "--at", "0.5,-0.5,0.5", "--normal", "0,1,0"});
  EXPECT_EQ(nothing.code, 2);
  EXPECT_THAT(nothing.err, HasSubstr("no surface lies there"));
}

TEST_F(Inspect, FocalDensitiesProjected) {
  Render({"--method", "focal"});
  auto pictures = Pictures(Json({scene_, "--pixel", "16,20", "-o", folder_ / "p", "--range", "0.5,50"}));
  for (const std::string axis : {"x", "y", "z"}) {
    ASSERT_TRUE(pictures.contains("focal-max-" + axis));
    EXPECT_NEAR(pictures["focal-mean-" + axis]["mean"].get<double>(), 1, 1e-2) << axis;
    EXPECT_GE(pictures["focal-max-" + axis]["max"].get<double>(), pictures["focal-mean-" + axis]["max"].get<double>());
  }
  EXPECT_GT(pictures["focal-max-camera"]["max"].get<double>(), 2);  // the light
  EXPECT_NEAR(pictures["guide"]["integral"].get<double>(), 1, 0.05);
  ExpectPaths(pictures);
  EXPECT_THAT(Run({}).out, HasSubstr("densest 1 %"));
}

TEST_F(Inspect, AGridsTableAndDirections) {
  Render({"--method", "grid"});
  const auto json = Json({scene_, "--pixel", "16,20", "-o", folder_ / "p"});
  EXPECT_GT(json["state"]["known_entries"].get<uint64_t>(), 100u);
  EXPECT_LE(json["state"]["known_entries"].get<uint64_t>(), json["state"]["entries"].get<uint64_t>());
  auto pictures = Pictures(json);
  for (const char* name : {"table", "guide", "bsdf"}) {
    ASSERT_TRUE(pictures.contains(name)) << name;
    EXPECT_NEAR(pictures[name]["integral"].get<double>(), 1, 0.02) << name;
  }
  ExpectPaths(pictures);
  EXPECT_THAT(Run({}).out, HasSubstr("directions a voxel"));
}

// What Parse() says of bytes; empty: nothing.
std::string Refusal(const std::string& bytes) {
  try {
    GuideFile::Parse(bytes, "a.lguide");
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST_F(Inspect, DamageOtherVersionsAndOtherScenesAreRefused) {
  Render({});
  const std::string good = ReadText(state_);
  EXPECT_EQ(Refusal(good), "");
  for (size_t at = 0; at < good.size(); at += 1 + good.size() / 97) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    EXPECT_THAT(Refusal(bad), AllOf(HasSubstr("a.lguide"), testing::AnyOf(HasSubstr("damaged"), HasSubstr("version"))))
        << at;
  }
  for (const size_t size : {size_t{0}, size_t{3}, size_t{20}, good.size() - 1})
    EXPECT_NE(Refusal(good.substr(0, size)), "") << size;
  std::string newer = good;
  newer[4] = 99;
  EXPECT_THAT(Refusal(newer), HasSubstr("version 99"));

  std::string text = kTinyScene;
  text.replace(text.find("0.5 0.6 0.7"), 11, "0.5 0.6 0.8");
  const Ran other = Run({folder_.Write("other.pbrt", text)});
  EXPECT_EQ(other.code, 4);
  EXPECT_THAT(other.err, AllOf(HasSubstr("another scene"), HasSubstr("other.pbrt")));
  EXPECT_EQ(Run({scene_}).code, 0);
  std::ofstream(state_, std::ios::binary) << newer;
  EXPECT_EQ(Run({}).code, 4);
  std::filesystem::remove(state_);
  EXPECT_EQ(Run({}).code, 4);
}

TEST_F(Inspect, WrongOptionsSayWhatToTry) {
  Render({});
  struct Case {
    GuideArguments arguments;
    const char* said;
  };
  const Case cases[] = {{{.at = "1,2"}, "3 numbers"},
                        {{.at = "1,2,3x"}, "3 numbers"},
                        {{.pixel = "1,2"}, "needs the scene"},
                        {{.scene = scene_, .pixel = "32,2"}, "32x24"},
                        {{.at = "0,0,0", .normal = "0,0,0"}, "no direction"},
                        {{.scene = scene_, .at = "0,1,0", .normal = "0,1,0", .roughness = 0.2f}, "has its own"},
                        {{.range = "8,1"}, "below HIGH"},
                        {{.range = "1,8"}, "'sdtree' has none"}};
  for (const Case& c : cases) {
    GuideArguments arguments = c.arguments;
    arguments.guide = state_;
    try {
      InspectGuide(arguments);
      ADD_FAILURE() << c.said;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
      EXPECT_THAT(error.what(), HasSubstr(c.said));
    }
  }
  // What would have no effect alone.
  for (const auto& [alone, other] :
       {std::pair{"--wo", "--normal"}, {"--normal", "--at"}, {"--roughness", "--normal"}, {"--range", "--output"}}) {
    const Ran ran = Run({alone, "1"});
    EXPECT_EQ(ran.code, 2) << alone;
    EXPECT_THAT(ran.err, HasSubstr(std::string(alone) + " requires " + other));
  }
  EXPECT_EQ(Run({"--at", "0,0,0", "--pixel", "1,1"}).code, 2);
  EXPECT_EQ(Run({"--resolution", "8x8"}).code, 2);
  EXPECT_EQ(RunLodestar({"inspect"}).code, 2);
  EXPECT_EQ(RunLodestar({"inspect", scene_, "--at", "0,0,0"}).code, 2);
  const Ran path =
      RunLodestar({"render", scene_, "--method", "path", "--state", folder_ / "x", "-o", folder_ / "x.exr"}, kNoPlot);
  EXPECT_EQ(path.code, 2);
  EXPECT_THAT(path.err, HasSubstr("learns nothing"));
}

TEST_F(Inspect, BothPartsOfAMixture) {
  Render({"--method", "sdtree+focal", "--option", "initial-iterations=1"});
  const nlohmann::json shown = Json({scene_, "--pixel", "16,20", "-o", folder_ / "mixed"});
  EXPECT_TRUE(shown["state"]["tree"].contains("spatial")) << shown["state"].dump();
  EXPECT_FALSE(shown["state"]["field"].empty());
  EXPECT_TRUE(shown["point"].contains("leaf") && shown["point"].contains("focal_share")) << shown["point"].dump();
  auto pictures = Pictures(shown);
  ExpectPaths(pictures);
  for (const char* name : {"dtree", "focal-max-x", "bsdf"}) EXPECT_TRUE(pictures.contains(name)) << name;
}

// What `auto` chose is what is shown.
TEST_F(Inspect, AStateOfAuto) {
  Render({"--method", "auto", "--option", "candidates=sdtree"});
  const nlohmann::json shown = Json({"--at", "0,0,0.1", "-o", folder_ / "auto"});
  EXPECT_EQ(shown["method"], "auto (sdtree)");
  EXPECT_TRUE(shown["state"].contains("spatial")) << shown["state"].dump();
  EXPECT_TRUE(Pictures(shown).contains("dtree-native"));  // the records of its last training are in the file
  EXPECT_EQ(shown["choice"], "sdtree");
  Render({"--method", "auto", "--option", "candidates=path,sdtree"});
  const Ran path = Run({});
  EXPECT_EQ(path.code, 0) << path.err;
  EXPECT_THAT(path.out, AllOf(HasSubstr("auto (path)"), HasSubstr("chose                 path: the budget ended")));
  const nlohmann::json chosen = Json({});
  EXPECT_EQ(chosen["method"], "auto (path)");
  EXPECT_THAT(chosen["choice"].get<std::string>(), HasSubstr("path: the budget ended"));
  EXPECT_FALSE(chosen.contains("state")) << chosen["state"].dump();
  EXPECT_EQ(Json({scene_})["scene_checked"], true);
  // There is nothing to draw, and no place to look at.
  for (const std::vector<std::string>& looks :
       {std::vector<std::string>{"-o", folder_ / "none"}, {"--at", "0,0,0.1"}, {scene_, "--pixel", "16,20"}}) {
    const Ran ran = Run(looks);
    EXPECT_EQ(ran.code, 2) << looks[0];
    EXPECT_THAT(ran.err, AllOf(HasSubstr("'auto (path)' learns nothing"), HasSubstr("Chose path: the budget ended")));
  }
}

// What a race has measured is told by the render's report and by the file alike, whoever has won.
TEST_F(Inspect, AStateOfAutoAfterARace) {
  const auto report = Render({"--method", "auto", "--option", "candidates=path,sdtree", "--option", "pilot=1000"});
  const auto choice = report["result"].value("choice", "");
  EXPECT_THAT(choice, AllOf(HasSubstr(" was "), HasSubstr(" times as efficient (95 %: ")));
  EXPECT_EQ(Json({})["choice"], choice);
  const Ran shown = Run({});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("chose                 " + choice));
}

// Channels of an EXR by name.
std::map<std::string, std::vector<float>> Channels(const std::string& path) {
  auto in = OIIO::ImageInput::open(path);
  std::map<std::string, std::vector<float>> channels;
  if (!in) return channels;
  const OIIO::ImageSpec& spec = in->spec();
  const auto n = static_cast<size_t>(spec.nchannels),
             pixels = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
  std::vector<float> values(n * pixels);
  in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data());
  for (size_t c = 0; c < n; ++c) {
    for (size_t i = 0; i < pixels; ++i) channels[spec.channelnames[c]].push_back(values[i * n + c]);
  }
  return channels;
}

TEST_F(Inspect, AovsAreChannelsOfTheExr) {
  const auto plain = Render({});
  const auto report = Render({"--aov", "albedo,normal,depth,bsdf-fraction,nee"});
  EXPECT_EQ(report["result"]["image_sha256"], plain["result"]["image_sha256"]);
  auto channels = Channels(folder_ / "a.exr");
  for (const char* name : {"R", "G", "B", "variance.Y", "albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "Z",
                           "guide.bsdf_fraction", "guide.nee"}) {
    EXPECT_EQ(channels[name].size(), 32u * 24) << name;
  }
  const size_t floor = 20 * 32 + 16, sky = 1;
  EXPECT_NEAR(channels["albedo.G"][floor], 0.6f, 1e-4f);
  EXPECT_NEAR(channels["N.Y"][floor], 1, 1e-4f);
  EXPECT_GT(channels["Z"][floor], 1);
  EXPECT_LT(channels["Z"][floor], 8);
  EXPECT_GE(channels["guide.bsdf_fraction"][floor], 0.05f);
  EXPECT_LE(channels["guide.bsdf_fraction"][floor], 0.95f);
  EXPECT_EQ(channels["albedo.R"][sky], 0);
  EXPECT_TRUE(std::isinf(channels["Z"][sky]));
  const Image map = ReadImageFile(report["files"]["fraction"].get<std::string>());
  EXPECT_EQ(map.width, 32u);
  EXPECT_EQ(map.pixels[sky], Rgb(0));
  EXPECT_GT(MaxComponent(map.pixels[floor]), 0.1f);

  const Ran upper = RunLodestar({"render", scene_, "--method", "path", "--spp", "1", "--resolution", "32x24", "--aov",
                                 "albedo", "-o", folder_ / "B.EXR"},
                                kNoPlot);
  EXPECT_EQ(upper.code, 0) << upper.err;
  EXPECT_EQ(Channels(folder_ / "B.EXR")["albedo.G"].size(), 32u * 24);
  EXPECT_EQ(RunLodestar({"render", scene_, "--aov", "albedo", "-o", folder_ / "a.png"}, kNoPlot).code, 2);
  EXPECT_THAT(RunLodestar({"render", scene_, "--aov", "albdo", "-o", folder_ / "a.exr"}).err,
              HasSubstr("did you mean albedo?"));
}

}  // namespace
}  // namespace lodestar
