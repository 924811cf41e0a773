// The built program against a farm of real processes: what each command says, writes and ends with.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/outputs.h"
#include "tests/client/run_program.h"
#include "tests/farm/support/box.h"
#include "tests/farm/support/farm_fixture.h"

namespace lodestar {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class FarmCommands : public FarmFixture {
 protected:
  void SetUp() override {
    StartCoordinator();
    StartWorker();
    StartWorker();
  }
  // As a user would, in `folder_`, in a shell that finds the program and knows the farm.
  Ran Shell(const std::string& command) {
    return RunProgram({"sh", "-c", "cd " + folder_.path().string() + " && " + command},
                      {"LODESTAR_FARM=127.0.0.1:" + std::to_string(port_), "LODESTAR_PLOT=/nonexistent",
                       "PATH=" + std::filesystem::path(LODESTAR_PROGRAM).parent_path().string() + ":/usr/bin:/bin"});
  }
  nlohmann::json Json(const Ran& ran) {
    EXPECT_EQ(ran.code, 0) << ran.err;
    return nlohmann::json::parse(ran.out, nullptr, false);
  }
  const std::string scene_ = (folder_.path() / "scene" / "box.pbrt").string();
};

TEST_F(FarmCommands, AJobFromSubmissionToItsReport) {
  const auto ended =
      Json(Shell("lodestar submit scene/box.pbrt --method path --spp 8 --seed 7 --watch --quiet --json"));
  const std::string id = ended["job"];
  EXPECT_EQ(ended["phase"], "done");
  EXPECT_EQ(ended["spp"], 8);

  const auto jobs = Json(Shell("lodestar jobs --json"))["jobs"];
  ASSERT_EQ(jobs.size(), 1u);
  EXPECT_EQ(jobs[0]["job"], id);
  EXPECT_EQ(jobs[0]["name"], "box");
  EXPECT_FALSE(Json(Shell("lodestar workers --json"))["workers"].empty());

  const auto delivered = Json(Shell("lodestar image " + id + " -o out/box.exr --json"));
  EXPECT_EQ(delivered["files"]["image"], "out/box.exr");
  const Image image = ReadImageFile(folder_.path() / "out/box.exr");
  EXPECT_EQ(image.pixels, RenderHere(box_, BoxJob("path", 8)).image.pixels);

  const auto report = Json(Shell("lodestar report " + id + " --json"));
  EXPECT_EQ(report["result"]["spp"], 8);
  EXPECT_EQ(report["scene"]["path"], scene_) << "as the client has it, wherever it is asked from";
  const Ran csv = Shell("lodestar report " + id + " --csv");
  EXPECT_THAT(csv.out, StartsWith("method,seed,seconds,spp,iteration,"));
  EXPECT_THAT(csv.out, HasSubstr("\npath,7,"));
  EXPECT_EQ(static_cast<size_t>(std::count(csv.out.begin(), csv.out.end(), '\n')), report["points"].size() + 1);
}

TEST_F(FarmCommands, EveryPointIsMeasuredAgainstTheReference) {
  ASSERT_EQ(Shell("lodestar render scene/box.pbrt --method path --spp 64 --seed 1 -o reference.pfm --quiet").code, 0);
  const std::string job = " scene/box.pbrt --method sdtree --spp 31 --reference reference.pfm --quiet --json -o ";
  const auto here = Json(Shell("lodestar render" + job + "here.exr"))["points"];
  const auto farm = Json(Shell("lodestar submit" + job + "farm.exr"))["points"];
  ASSERT_GT(here.size(), 2u);
  ASSERT_EQ(farm.size(), here.size());
  for (size_t i = 0; i < here.size(); ++i) {
    EXPECT_GT(here[i]["reference"]["relmse_trimmed"].get<double>(), 0);
    EXPECT_EQ(farm[i]["reference"], here[i]["reference"]) << i;
  }
  const Ran small = Shell("lodestar submit scene/box.pbrt --resolution 8x6 --reference reference.pfm");
  EXPECT_EQ(small.code, 2) << small.err;
}

TEST_F(FarmCommands, AWorkerRendersAJobOnAsManyThreadsAsBothAllow) {
  for (auto& worker : workers_) worker.Kill();
  StartWorker({}, 3);
  const Image expected = RenderHere(box_, BoxJob("path", 4)).image;
  const std::string submit = "lodestar submit scene/box.pbrt --method path --spp 4 --seed 7 --json -o out/box.exr ";
  for (const auto& [asked, on] : {std::pair{"", "3 of 3"}, {"--threads 2", "2 of 3"}, {"--threads 5", "3 of 3"}}) {
    std::filesystem::resize_file(folder_.path() / "workers.log", 0);
    EXPECT_EQ(Json(Shell(submit + asked))["phase"], "done");
    EXPECT_THAT(Log(), HasSubstr(std::string("to render on ") + on + " threads")) << asked;
    EXPECT_EQ(ReadImageFile(folder_.path() / "out/box.exr").pixels, expected.pixels) << asked;
  }
}

TEST_F(FarmCommands, ACancelledJobEndsItsWatchWithSix) {
  const Ran submitted = Shell("lodestar submit scene/box.pbrt --method path --spp 1000000");
  ASSERT_EQ(submitted.code, 0) << submitted.err;
  const std::string id = submitted.out.substr(0, submitted.out.find('\n'));
  const Ran cancelled = Shell("lodestar cancel " + id);
  EXPECT_EQ(cancelled.code, 0) << cancelled.err;
  EXPECT_EQ(cancelled.out, "cancelled " + id + "\n");
  const Ran watched = Shell("lodestar watch " + id + " --quiet");
  EXPECT_EQ(watched.code, 6);
  EXPECT_THAT(watched.err, HasSubstr(id + " cancelled"));
  EXPECT_EQ(Shell("lodestar cancel job-99").code, 6) << "there is none";
}

TEST_F(FarmCommands, CancellingSaysWhatBecameOfEachJob) {
  const std::string done = Json(Shell("lodestar submit scene/box.pbrt --method path --spp 1 --watch --json"))["job"];
  const std::string submitted = Shell("lodestar submit scene/box.pbrt --method path --spp 1000000").out;
  const std::string running = submitted.substr(0, submitted.find('\n'));
  const Ran cancelled = Shell("lodestar cancel job-99 " + done + " " + running);
  EXPECT_EQ(cancelled.code, 6);
  EXPECT_THAT(cancelled.err, HasSubstr("job-99"));
  EXPECT_EQ(cancelled.out, done + " had ended before: done\ncancelled " + running + "\n");
  const Ran again = Shell("lodestar cancel job-99 --json " + done + " " + running);
  EXPECT_EQ(nlohmann::json::parse(again.out), (nlohmann::json{{"cancelled", {running}}, {"ended", {done}}}));
}

TEST_F(FarmCommands, AWatchEndsAtOnceWhateverTheJobWaitsFor) {
  for (auto& worker : workers_) worker.Kill();
  const std::string submitted = Shell("lodestar submit scene/box.pbrt --spp 4").out;
  const std::string id = submitted.substr(0, submitted.find('\n'));
  // Interrupted once it catches the signal: the program, not the shell that is about to become it.
  const std::string interrupted = "timeout -s KILL 60 sh -c 'lodestar watch " + id +
                                  " & until grep -q lodestar /proc/$!/comm && grep -q \"^SigCgt:.*[2367abef]$\" "
                                  "/proc/$!/status; do sleep 0.05; done; "
                                  "kill -INT $!; wait $!'";
  const Ran watched = Shell(interrupted);
  EXPECT_EQ(watched.code, 130) << watched.err;
  EXPECT_THAT(watched.err, HasSubstr("lodestar cancel " + id));
  // Not even the coordinator.
  coordinator_.Kill();
  EXPECT_EQ(Shell(interrupted).code, 130);
}

// It takes ten seconds of the job's: the first picture comes then.
TEST_F(FarmCommands, AWatchThatIsKilledLeavesThePictureSoFar) {
  const std::string submitted = Shell("lodestar submit scene/box.pbrt --method path --time 2m").out;
  const std::string id = submitted.substr(0, submitted.find('\n'));
  const Ran watched = Shell("{ lodestar watch " + id +
                            " -o a.exr --quiet & for i in $(seq 900); do [ -e a.png ] && break; sleep 0.1; done; "
                            "kill -KILL $!; wait $!; }");
  EXPECT_EQ(watched.code, 137) << watched.err;
  for (const char* name : {"a.exr", "a.png"}) EXPECT_EQ(ReadImageFile(folder_.path() / name).width, 64u) << name;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "a.json")) << "it was not killed";
}

TEST_F(FarmCommands, TheImageIsWrittenWhateverIsWrongBesides) {
  ASSERT_EQ(Shell("lodestar render scene/box.pbrt --method path --spp 1 --resolution 8x6 -o small.pfm --quiet").code,
            0);
  const std::string id = Json(Shell("lodestar submit scene/box.pbrt --method path --spp 4 --watch --json"))["job"];
  const Ran small = Shell("lodestar image " + id + " -o a.exr --reference small.pfm");
  EXPECT_EQ(small.code, 2);
  EXPECT_THAT(small.err, HasSubstr("8x6"));
  const Ran nothing = Shell("lodestar image " + id + " -o b.exr --state b.lguide");
  EXPECT_EQ(nothing.code, 6);
  EXPECT_THAT(nothing.err, HasSubstr("learns nothing"));
  for (const char* image : {"a.exr", "b.exr"}) EXPECT_EQ(ReadImageFile(folder_.path() / image).width, 64u) << image;
}

TEST_F(FarmCommands, WhatIsNotSupportedIsRefusedHereUnlessLenient) {
  folder_.Write("scene/odd.pbrt", std::string(kBoxScene) + "Shape \"curve\"\n");
  const Ran strict = Shell("lodestar submit scene/odd.pbrt --spp 4");
  EXPECT_EQ(strict.code, 3);
  EXPECT_THAT(strict.err, AllOf(HasSubstr("odd.pbrt:"), HasSubstr("curve")));
  EXPECT_TRUE(client().ListJobs().empty()) << "nothing was sent";
  const Ran lenient = Shell("lodestar submit scene/odd.pbrt --method path --spp 4 --lenient -o odd.exr --json");
  EXPECT_THAT(lenient.err, HasSubstr("left out (--lenient)"));
  const auto report = Json(lenient);
  ASSERT_EQ(report["scene"]["left_out"].size(), 1u);
  EXPECT_THAT(report["scene"]["left_out"][0].get<std::string>(), StartsWith("odd.pbrt:"));
  EXPECT_EQ(ReadImageFile(folder_.path() / "odd.exr").width, 64u);
}

// Workers have other folders.
TEST_F(FarmCommands, AbsoluteNamesAreRefusedHere) {
  const auto part = folder_.Write("scene/part.pbrt", "Shape \"sphere\"\n");
  folder_.Write("scene/absolute.pbrt", std::string(kBoxScene) + "Include \"" + part.string() + "\"\n");
  const Ran ran = Shell("lodestar submit scene/absolute.pbrt --spp 4");
  EXPECT_EQ(ran.code, 3);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("absolute.pbrt:"), HasSubstr("is an absolute name")));
  EXPECT_TRUE(client().ListJobs().empty()) << "nothing was sent";
}

TEST_F(FarmCommands, TheReplayCommandOfAReportRuns) {
  folder_.Write("scene/blinding.pbrt", std::string(kPlainFloor) + kBlindingLight);
  const std::string id =
      Json(Shell("cd scene && lodestar submit blinding.pbrt --method path --spp 31 --watch --quiet --json"))["job"];
  const auto health = Json(Shell("lodestar report " + id + " --json"))["health"];
  ASSERT_EQ(health["first"]["event"], "infinite") << health;
  const std::string command = health["replay"];
  EXPECT_EQ(Json(Shell(command + " --json"))["event"], "infinite") << command;
  const Ran image = Shell("lodestar image " + id + " -o blinding.exr");
  EXPECT_THAT(image.out, HasSubstr(command));
}

}  // namespace
}  // namespace lodestar
