// The built program: what it writes, what it says of wrong input, and how it ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "client/outputs.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// Plots cost a second each; where they are not what is tested, no script is found.
const std::vector<std::string> kNoPlot = {"LODESTAR_PLOT=/nonexistent"};

nlohmann::json Json(const Ran& ran) {
  return nlohmann::json::parse(ran.out, nullptr, false);
}

TEST(Program, HelpListsCommandsOptionsDefaultsAndExamples) {
  const Ran top = RunLodestar({"--help"});
  EXPECT_EQ(top.code, 0);
  for (const char* command : {"render", "submit", "jobs", "watch", "cancel", "image", "report", "compare", "inspect",
                              "replay", "diff", "workers"}) {
    EXPECT_THAT(top.out, HasSubstr(command));
    const Ran ran = RunLodestar({command, "--help"});
    EXPECT_EQ(ran.code, 0) << command;
    EXPECT_THAT(ran.out, HasSubstr("--json")) << command;
  }
  const Ran render = RunLodestar({"render", "--help"});
  for (const char* part :
       {"--method", "--spp", "--time", "--error", "--resolution", "--filter", "--max-depth", "--threads", "--seed",
        "--output", "--option", "--nee", "--combine", "--training-iterations", "--reference", "Examples:"}) {
    EXPECT_THAT(render.out, HasSubstr(part));
  }
  EXPECT_THAT(RunLodestar({"--version"}).out, StartsWith("lodestar 0."));
}

TEST(Program, WrongWordsSuggestWhatWasMeant) {
  struct Case {
    std::vector<std::string> arguments;
    const char* said;
  };
  const Case cases[] = {{{"rendr", "x"}, "did you mean render?"},
                        {{"render", "x.pbrt", "--sppp", "4"}, "did you mean --spp?"},
                        {{"render", "x.pbrt", "--method", "sdtre"}, "did you mean sdtree or sdtree+focal?"},
                        {{"render", "x.pbrt", "--method", "path", "--combine", "discard"}, "have it: sdtree, focal"},
                        {{"render", "x.pbrt", "--method", "auto", "--target", "full"},
                         "but these have it: sdtree, sdtree+focal; choose with"},
                        {{"render", "x.pbrt", "--time", "soon"}, "60s"},
                        {{"render", "x.pbrt", "--resolution", "12"}, "640x360"},
                        {{"render", "x.pbrt", "-o", "x.jpg"}, ".exr"},
                        {{"render", "x.pbrt", "--spp", "0"}, "--spp: '0' must be a number above 0"},
                        {{"inspect", "x.pbrt", "--seed", "-1"}, "--seed: '-1' must be a number, 0 or above"},
                        {{"jobs", "--farm", "localhost"}, "'localhost' must be HOST:PORT, as in"},
                        {{"jobs", "--farm", ":7420"}, "must be HOST:PORT"},
                        {{"jobs", "--farm", "localhost:99999"}, "must be HOST:PORT"},
                        {{"jobs", "--farm", "localhost:74x"}, "must be HOST:PORT"},
                        {{"watch", "job-1", "--reference", "x.exr"}, "--reference needs -o"},
                        {{"render"}, "scene"},
                        {{"compare", "x.pbrt", "--methods", "path,pth", "-o", "/tmp/never"}, "did you mean path?"}};
  for (const Case& c : cases) {
    const Ran ran = RunLodestar(c.arguments);
    EXPECT_EQ(ran.code, 2) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(c.said));
    EXPECT_THAT(ran.err, HasSubstr("--help"));
    EXPECT_THAT(ran.out, IsEmpty());
  }
}

TEST(Program, BadScenesEndWithThreeAndNameTheLine) {
  TemporaryFolder folder;
  const Ran missing = RunLodestar({"inspect", folder / "none.pbrt"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.err, HasSubstr("none.pbrt"));
  const Ran wrong = RunLodestar({"inspect", folder.Write("wrong.pbrt", "WorldBegin\nShape \"teapot\"\n")});
  EXPECT_EQ(wrong.code, 3);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("wrong.pbrt:2:"), HasSubstr("teapot")));
}

TEST(Program, FilesThatCannotBeReadOrWrittenEndWithFour) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  EXPECT_EQ(RunLodestar({"render", scene, "-o", "/proc/none/x.exr"}).code, 4);
  EXPECT_EQ(RunLodestar({"render", scene, "-o", folder / "x.exr", "--reference", folder / "none.exr"}).code, 4);
  EXPECT_EQ(RunLodestar({"diff", folder / "none.exr", folder / "none.exr"}).code, 4);
  // Known before the job has ended, and before the farm is asked.
  const Ran watch = RunLodestar(
      {"watch", "job-1", "--farm", "127.0.0.1:1", "-o", folder / "x.exr", "--reference", folder / "none.exr"});
  EXPECT_EQ(watch.code, 4);
  EXPECT_THAT(watch.err, HasSubstr("none.exr: no such file"));
  const Ran text = RunLodestar({"inspect", "--guide", scene});
  EXPECT_EQ(text.code, 4);
  EXPECT_THAT(text.err, AllOf(HasSubstr("tiny.pbrt"), HasSubstr("--state FILE` writes one")));
}

// Refused to root as well: a name too long for the one beside it, and names that are folders.
TEST(Program, TheImageIsWrittenWhateverElseCannotBe) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene), state = folder / std::string(252, 's');
  for (const char* taken : {"a.png", "a.csv"}) std::filesystem::create_directory(folder / taken);
  const Ran ran = RunLodestar({"render", scene, "--method", "sdtree", "--spp", "15", "-o", folder / "a.exr", "--state",
                               state, "--json", "--quiet"},
                              kNoPlot);
  EXPECT_EQ(ran.code, 4);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("a.png"), HasSubstr("a.csv"), HasSubstr(state)));
  EXPECT_EQ(ReadImageFile(folder / "a.exr").width, 16u);
  const nlohmann::json files = {{"image", (folder / "a.exr").string()}, {"json", (folder / "a.json").string()}};
  EXPECT_EQ(Json(ran)["files"], files);
  EXPECT_EQ(nlohmann::json::parse(ReadText(folder / "a.json"))["files"], files);
}

TEST(Program, StandardOutputOnAFullDiskEndsWithFour) {
  const TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene).string();
  for (const std::string& command :
       {"inspect '" + scene + "' --json", std::string("--help"), std::string("--version")}) {
    const Ran ran = RunProgram({"sh", "-c", "'" LODESTAR_PROGRAM "' " + command + " >/dev/full"});
    EXPECT_EQ(ran.code, 4) << command;
    EXPECT_THAT(ran.err, HasSubstr("standard output")) << command;
  }
}

TEST(Program, InspectSaysWhatTheSceneHolds) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran = RunLodestar({"inspect", scene, "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto json = Json(ran);
  EXPECT_EQ(json["triangles"], 4);
  EXPECT_EQ(json["lights"]["area"], 1);
  EXPECT_EQ(json["resolution"], (nlohmann::json{16, 12}));
  EXPECT_TRUE(json["left_out"].empty());
  // What is not needed is another thing than what --lenient leaves out.
  EXPECT_EQ(json["needs"], "smooth-lobes area-lights");
  const std::string not_needed =
      "environment, textures and mixes, delta lobes (left out of the path kernel); "
      "alpha, instances, quadrics (left out of the intersector); lens (left out of camera rays)";
  EXPECT_EQ(json["not_needed"], not_needed);
  EXPECT_THAT(RunLodestar({"inspect", scene}).out,
              AllOf(HasSubstr("triangles   4"), HasSubstr("not needed  " + not_needed + "\n"),
                    HasSubstr("left out    nothing\n")));
  const std::string mirrors = folder.Write(
      "mirrors.pbrt", R"(WorldBegin LightSource "infinite" Material "dielectric" Shape "sphere" "float radius" [1])");
  EXPECT_EQ(Json(RunLodestar({"inspect", mirrors, "--json"}))["not_needed"],
            "textures and mixes (left out of the path kernel); alpha, instances (left out of the intersector); "
            "lens (left out of camera rays); "
            "guiding (left out of method 'auto')");
}

TEST(Program, ARenderWritesItsFilesAndOneJsonDocument) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran = RunLodestar(
      {"render", scene, "--method", "path", "--spp", "8", "--seed", "5", "-o", folder / "out/a.exr", "--json"},
      kNoPlot);
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto json = Json(ran);
  ASSERT_TRUE(json.is_object()) << ran.out;
  EXPECT_EQ(json["result"]["spp"], 8);
  EXPECT_EQ(json["result"]["stop_reason"], "spp");
  EXPECT_GT(json["result"]["seconds_compiling"], 0);
  EXPECT_LT(json["result"]["seconds_compiling"], 60);
  EXPECT_EQ(json["scene"]["not_needed"],
            "environment, textures and mixes, delta lobes (left out of the path kernel); "
            "alpha, instances, quadrics (left out of the intersector); lens (left out of camera rays)");
  EXPECT_EQ(json["health"]["total"], 0);
  EXPECT_FALSE(json["points"].empty());
  for (const char* kind : {"image", "png", "csv", "json"})
    EXPECT_TRUE(std::filesystem::exists(json["files"][kind].get<std::string>())) << kind;
  EXPECT_EQ(nlohmann::json::parse(ReadText(folder / "out/a.json"))["job"]["seed"], 5);
  EXPECT_THAT(ReadText(folder / "out/a.csv"), StartsWith("method,seed,seconds,spp,iteration,"));
  EXPECT_THAT(ran.err, HasSubstr("no plot"));
  const Image image = ReadImageFile(folder / "out/a.exr");
  EXPECT_EQ(image.width, 16u);
  float brightest = 0;
  for (const Rgb& pixel : image.pixels) brightest = std::max(brightest, pixel.g);
  EXPECT_GT(brightest, 0.01f);
}

TEST(Program, TheSameCommandGivesTheSameBitsOnAnyNumberOfThreads) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  for (const char* threads : {"1", "3"}) {
    const Ran ran = RunLodestar({"render", scene, "--spp", "15", "--threads", threads, "-o",
                                 folder / (std::string(threads) + ".pfm"), "--quiet"},
                                kNoPlot);
    ASSERT_EQ(ran.code, 0) << ran.err;
  }
  EXPECT_EQ(ReadText(folder / "1.pfm"), ReadText(folder / "3.pfm"));
}

TEST(Program, AReferenceGivesErrorsAndAWrongSizeIsSaidBeforeRendering) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  ASSERT_EQ(
      RunLodestar({"render", scene, "--method", "path", "--spp", "64", "-o", folder / "ref.exr", "--quiet"}, kNoPlot)
          .code,
      0);
  const Ran ran = RunLodestar({"render", scene, "--method", "path", "--spp", "4", "--seed", "1", "--reference",
                               folder / "ref.exr", "-o", folder / "a.exr", "--json"},
                              kNoPlot);
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_GT(Json(ran)["points"].back()["reference"]["relmse_trimmed"].get<double>(), 0);
  const Ran wrong = RunLodestar(
      {"render", scene, "--resolution", "8x6", "--reference", folder / "ref.exr", "-o", folder / "b.exr"}, kNoPlot);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--resolution 16x12"));

  const Ran diff = RunLodestar({"diff", folder / "a.exr", folder / "ref.exr", "-o", folder / "map.png", "--json"});
  ASSERT_EQ(diff.code, 0) << diff.err;
  EXPECT_GT(Json(diff)["rmse"].get<double>(), 0);
  EXPECT_EQ(ReadImageFile(folder / "map.png").width, 16u);
  EXPECT_EQ(Json(RunLodestar({"diff", folder / "ref.exr", folder / "ref.exr", "--json"}))["rmse"], 0.0);
}

TEST(Program, CompareReportsEveryMethodAndSeed) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran = RunLodestar({"compare", scene, "--methods", "path,path:nee=never", "--spp", "4", "--seeds", "2", "-o",
                               folder / "r", "--json", "--quiet"},
                              kNoPlot);
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto json = Json(ran);
  ASSERT_EQ(json["methods"].size(), 2u);
  EXPECT_EQ(json["methods"][1]["method"], "path:nee=never");
  EXPECT_EQ(json["methods"][1]["runs"].size(), 2u);
  EXPECT_EQ(json["equal"]["by"], "seconds") << "their samples are equal by the budget";
  EXPECT_EQ(json["equal"]["methods"].size(), 2u);
  for (const char* file : {"r/report.md", "r/report.html", "r/compare.csv", "r/compare.json", "r/path-seed0.exr",
                           "r/path_nee_never-seed1.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  }
}

TEST(Program, ReplayGivesTheSamplesOwnBits) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  // With a box filter and one pass the image is the sample.
  ASSERT_EQ(
      RunLodestar({"render", scene, "--method", "path", "--spp", "1", "-o", folder / "one.exr", "--quiet"}, kNoPlot)
          .code,
      0);
  const Image image = ReadImageFile(folder / "one.exr");
  for (const uint32_t x : {3u, 8u}) {
    const Ran ran = RunLodestar(
        {"replay", scene, "--method", "path", "--pixel", std::to_string(x) + ",7", "--pass", "0", "--json"});
    ASSERT_EQ(ran.code, 0) << ran.err;
    const auto radiance = Json(ran)["radiance"];
    const Rgb expected = image.pixels[7 * image.width + x];
    EXPECT_EQ(radiance[0].get<float>(), expected.r);
    EXPECT_EQ(radiance[2].get<float>(), expected.b);
  }
  EXPECT_EQ(RunLodestar({"replay", scene, "--pixel", "99,0", "--pass", "0"}).code, 2);
  EXPECT_EQ(RunLodestar({"replay", scene, "--method", "path", "--pixel", "0,0", "--pass", "9", "--spp", "4"}).code, 2);
}

TEST(Program, ReplayFollowsTheTraining) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran = RunLodestar({"replay", scene, "--method", "sdtree", "--spp", "15", "--pixel", "8,7", "--pass", "5",
                               "--iteration", "2", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const Ran again = RunLodestar({"replay", scene, "--method", "sdtree", "--spp", "15", "--pixel", "8,7", "--pass", "5",
                                 "--iteration", "2", "--json", "--threads", "3"});
  EXPECT_EQ(ran.out, again.out);
  // Pass 5 belongs to iteration 2 (passes 3 to 6), not to iteration 0.
  EXPECT_EQ(RunLodestar({"replay", scene, "--method", "sdtree", "--spp", "15", "--pixel", "8,7", "--pass", "5",
                         "--iteration", "0"})
                .code,
            2);
}

TEST(Program, AnInterruptWritesTheImageSoFar) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran = RunProgram({"timeout", "--foreground", "--preserve-status", "-s", "INT", "2", LODESTAR_PROGRAM,
                              "render", scene, "--method", "path", "--time", "1h", "-o", folder / "a.pfm"},
                             kNoPlot);
  EXPECT_EQ(ran.code, 130) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("stopping"));
  EXPECT_EQ(ReadImageFile(folder / "a.pfm").width, 16u);
}

TEST(Program, AnInterruptWhileFilesAreWrittenLosesNone) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran =
      RunLodestar({"render", scene, "--method", "path", "--spp", "4", "-o", folder / "a.pfm"},
                  {"LODESTAR_PYTHON=/bin/sh", "LODESTAR_PLOT=" + folder.Write("plot", "kill -INT $PPID").string()});
  EXPECT_EQ(ran.code, 0) << "it was rendered as asked for; " << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("stopping"));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.json")) << "the last of them";
}

TEST(Program, AConnectionThatDropsLosesNoFileEither) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  // The shell hangs up first, and then the kernel. A program inherits that it is ignored, as from nohup.
  const std::string plot = folder.Write("plot", "kill -HUP $PPID; sleep 0.2; kill -HUP $PPID").string();
  for (const auto handler : {SIG_DFL, SIG_IGN}) {
    const auto before = std::signal(SIGHUP, handler);
    const Ran ran = RunLodestar({"render", scene, "--method", "path", "--spp", "4", "-o", folder / "a.pfm"},
                                {"LODESTAR_PYTHON=/bin/sh", "LODESTAR_PLOT=" + plot});
    std::signal(SIGHUP, before);
    EXPECT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(ran.err.find("stopping") != std::string::npos, handler == SIG_DFL) << ran.err;
    EXPECT_TRUE(std::filesystem::remove(folder / "a.json")) << "the last of them";
  }
}

TEST(Program, AConnectionThatDropsEndsARender) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const auto before = std::signal(SIGHUP, SIG_DFL);
  const Ran ran = RunProgram({"timeout", "--foreground", "--preserve-status", "-s", "HUP", "2", LODESTAR_PROGRAM,
                              "render", scene, "--method", "path", "--time", "1h", "-o", folder / "a.pfm"},
                             kNoPlot);
  std::signal(SIGHUP, before);
  EXPECT_EQ(ran.code, 130) << ran.err;
  EXPECT_EQ(ReadImageFile(folder / "a.pfm").width, 16u);
}

TEST(Program, AReaderThatIsGoneEndsNoRender) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  // The reader has gone before the first line.
  const Ran ran = RunProgram({"bash", "-c", "exec 2> >(exec true); sleep 0.3; \"$@\"", "bash", LODESTAR_PROGRAM,
                              "render", scene, "--method", "path", "--spp", "4", "-o", folder / "a.pfm"},
                             kNoPlot);
  EXPECT_EQ(ran.code, 0);
  EXPECT_EQ(ReadImageFile(folder / "a.pfm").width, 16u);
  EXPECT_TRUE(std::filesystem::exists(folder / "a.json")) << "the last of them";
}

// It takes its ten seconds: the first picture comes then.
TEST(Program, ARenderThatIsKilledLeavesItsPictureSoFar) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran =
      RunProgram({"sh", "-c",
                  "\"$0\" render \"$1\" --method path --time 2m -o \"$2.exr\" --json --quiet & "
                  "for i in $(seq 900); do [ -e \"$2.png\" ] && break; sleep 0.1; done; kill -KILL $!; wait $!",
                  LODESTAR_PROGRAM, scene, folder / "a"});
  EXPECT_EQ(ran.code, 137) << ran.err;
  for (const char* name : {"a.exr", "a.png"}) EXPECT_EQ(ReadImageFile(folder / name).width, 16u) << name;
  EXPECT_FALSE(std::filesystem::exists(folder / "a.json")) << "it was not killed";
}

TEST(Program, AnInterruptedComparisonReportsTheRunsThatAreWhole) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  const Ran ran =
      RunProgram({"timeout", "--foreground", "--preserve-status", "-s", "INT", "3", LODESTAR_PROGRAM, "compare", scene,
                  "--methods", "path", "--time", "100ms", "--seeds", "10000", "-o", folder / "r", "--json", "--quiet"},
                 kNoPlot);
  EXPECT_EQ(ran.code, 130) << ran.err;
  const auto json = Json(ran);
  ASSERT_TRUE(json.is_object()) << ran.out;
  EXPECT_FALSE(json["methods"][0]["runs"].empty());
  EXPECT_TRUE(std::filesystem::exists(folder / "r/report.html"));
}

TEST(Program, AFarmThatDoesNotAnswerEndsWithFive) {
  // Port 1 of the loopback: nothing listens there.
  const Ran ran = RunLodestar({"jobs", "--farm", "127.0.0.1:1", "--retry", "0.2"});
  EXPECT_EQ(ran.code, 5) << ran.err;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("127.0.0.1:1"), HasSubstr("--farm")));
}

}  // namespace
}  // namespace lodestar
