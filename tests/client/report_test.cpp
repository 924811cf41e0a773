#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "client/delivery.h"
#include "client/replay_text.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

using testing::HasSubstr;

JobReport Sample() {
  JobReport report;
  report.job.method = "sdtree";
  report.job.options["nee"] = "always";
  report.job.seed = 7;
  report.survey.resolution_x = 32;
  report.survey.resolution_y = 16;
  report.survey.max_depth = 5;
  report.survey.scene_hash = "abc";
  report.passes = 31;
  report.training_iterations = 4;
  report.seconds = 2;
  report.rays = 1000;
  report.stop_reason = "spp";
  report.points.push_back(
      {.seconds = 0.5, .spp = 3, .iteration = 1, .relmse_estimated = 0.25, .against_reference = {}});
  report.points.push_back({.seconds = 2,
                           .spp = 31,
                           .iteration = 4,
                           .relmse_estimated = 0.125,
                           .against_reference = ErrorMetrics{1, 2, 3, 4, 5}});
  return report;
}

TEST(Report, JsonHasTheDocumentedMembers) {
  const nlohmann::json json = ReportToJson(Sample());
  EXPECT_EQ(json["job"]["method"], "sdtree");
  EXPECT_EQ(json["job"]["options"]["nee"], "always");
  EXPECT_EQ(json["scene"]["resolution"], (nlohmann::json{32, 16}));
  EXPECT_EQ(json["result"]["spp"], 31);
  EXPECT_EQ(json["result"]["stop_reason"], "spp");
  EXPECT_EQ(json["result"]["rays_per_second"], 500.0);
  EXPECT_EQ(json["health"]["total"], 0);
  EXPECT_EQ(json["points"].size(), 2u);
  EXPECT_FALSE(json["points"][0].contains("reference"));
  EXPECT_EQ(json["points"][1]["reference"]["relmse_trimmed"], 5.0);
  EXPECT_FALSE(json["result"].contains("choice"));
  JobReport chosen = Sample();
  chosen.choice = "path; sdtree left out";
  EXPECT_EQ(ReportToJson(chosen)["result"]["choice"], "path; sdtree left out");
}

TEST(Report, PointsSurviveJson) {
  const auto points = PointsFromJson(nlohmann::json::parse(PointsToJson(Sample().points).dump()));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].seconds, 0.5);
  EXPECT_FALSE(points[0].against_reference.has_value());
  EXPECT_EQ(points[1].spp, 31u);
  EXPECT_EQ(points[1].against_reference->mae, 3);
  EXPECT_TRUE(PointsFromJson(nlohmann::json("not a list")).empty());
}

TEST(Report, CsvHasAsManyCellsAsItsHeader) {
  const std::string csv = kCsvHeader + PointsToCsv("sdtree:a=1,b=2", 7, Sample().points);
  EXPECT_EQ(csv,
            "method,seed,seconds,spp,iteration,relmse_estimated,rmse,mse,mae,relmse,relmse_trimmed\n"
            "\"sdtree:a=1,b=2\",7,0.5,3,1,0.25,,,,,\n"
            "\"sdtree:a=1,b=2\",7,2,31,4,0.125,1,2,3,4,5\n");
}

TEST(Report, CsvLabelsAreQuotedWhereTheyMustBe) {
  const std::vector<ErrorPoint> one(1);
  EXPECT_THAT(PointsToCsv("plain", 0, one), testing::StartsWith("plain,0,"));
  EXPECT_THAT(PointsToCsv("say \"a,b\"", 0, one), testing::StartsWith("\"say \"\"a,b\"\"\",0,"));
  EXPECT_THAT(PointsToCsv("a\nb", 0, one), testing::StartsWith("\"a\nb\",0,"));
}

TEST(Report, WhatIsNoErrorIsUnknown) {
  const auto points = PointsFromJson(nlohmann::json::parse(
      R"([{"relmse_estimated": null}, {"relmse_estimated": -1}, {}, {"relmse_estimated": 0.5}])"));
  ASSERT_EQ(points.size(), 4u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(points[static_cast<size_t>(i)].relmse_estimated, INFINITY) << i;
  EXPECT_EQ(points[3].relmse_estimated, 0.5);
  EXPECT_EQ(PointsFromJson(nlohmann::json::array({{{"relmse_estimated", NAN}}}))[0].relmse_estimated, INFINITY);
}

TEST(Report, NamesThatAreNotUtf8DoNotEndTheRender) {
  JobReport report = Sample();
  report.survey.SetLeftOut({"caf\xe9.pbrt:1:1: x"});
  const std::string text = DumpJson(ReportToJson(report));
  EXPECT_THAT(text, HasSubstr("caf\xef\xbf\xbd.pbrt"));
  EXPECT_TRUE(nlohmann::json::accept(text));
}

TEST(Report, InfinitiesAreNullInJsonAndEmptyInCsv) {
  JobReport report = Sample();
  report.points[0].relmse_estimated = INFINITY;
  const nlohmann::json json = nlohmann::json::parse(ReportToJson(report).dump());
  EXPECT_TRUE(json["points"][0]["relmse_estimated"].is_null());
  EXPECT_EQ(PointsFromJson(json["points"])[0].relmse_estimated, INFINITY);
  EXPECT_THAT(PointsToCsv("path", 0, report.points), HasSubstr("path,0,0.5,3,1,,"));
}

TEST(Report, TheReplayCommandNamesTheFirstOffenderAndTheJobsEnd) {
  JobReport report = Sample();
  EXPECT_EQ(ReplayCommand(ReportToJson(report), "s.pbrt"), "");
  report.health.Count(HealthEvent::kNan, 9, 4, 12, 3);
  EXPECT_EQ(ReplayCommand(ReportToJson(report), "my scene.pbrt"),
            "lodestar replay 'my scene.pbrt' --method sdtree --option nee=always --seed 7 --resolution 32x16 "
            "--max-depth 5 --spp 31 --training-iterations 4 "
            "--pixel 9,4 --pass 12 --iteration 3");
  report.job.lenient = true;
  EXPECT_THAT(ReplayCommand(ReportToJson(report), "s.pbrt"), HasSubstr(" --lenient "));
  EXPECT_EQ(ReplayCommand(nlohmann::json{{"health", {{"first", "of another version"}}}}, "s.pbrt"), "");
}

TEST(Report, WhatWasLeftOutIsListed) {
  JobReport report = Sample();
  report.job.lenient = true;
  report.survey.SetLeftOut({"s.pbrt:3:1: Shape \"curve\" is not supported"});
  const nlohmann::json json = ReportToJson(report);
  EXPECT_EQ(json["job"]["lenient"], true);
  EXPECT_EQ(json["scene"]["left_out"].size(), 1u);
  EXPECT_THAT(Summary(json), HasSubstr("s.pbrt:3:1: Shape \"curve\""));
  EXPECT_THAT(Summary(ReportToJson(Sample())), testing::Not(HasSubstr("left out")));
}

TEST(Report, TheSummarySaysWhatTheSceneDoesNotNeed) {
  JobReport report = Sample();
  report.survey.not_needed = "environment (left out of the path kernel)";
  const nlohmann::json json = ReportToJson(report);
  EXPECT_EQ(json["scene"]["not_needed"], report.survey.not_needed);
  EXPECT_THAT(Summary(json), HasSubstr("not needed by the scene: environment (left out of the path kernel)\n"));
}

TEST(Report, TheSummaryTellsOfBadSamples) {
  JobReport report = Sample();
  report.health.Count(HealthEvent::kNan, 9, 4, 12, 3);
  const std::string text = Summary(CompleteReport(ReportToJson(report), {"s.pbrt", "lodestar render s.pbrt"}));
  EXPECT_THAT(text, HasSubstr("31 spp"));
  EXPECT_THAT(text, HasSubstr(std::string(HealthEventName(HealthEvent::kNan)) + " 1"));
  EXPECT_THAT(text, HasSubstr("lodestar replay s.pbrt"));
}

}  // namespace
}  // namespace lodestar
