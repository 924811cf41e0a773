#include "client/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "client/job_options.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

ComparisonRun RunOf(const std::string& label, uint64_t seed, double error, double seconds) {
  ComparisonRun run;
  run.label = label;
  run.seed = seed;
  run.report.seconds = seconds;
  run.report.passes = 8;
  run.report.points.push_back({.seconds = seconds, .spp = 8, .relmse_estimated = 9, .against_reference = {}});
  run.metrics = ErrorMetrics{1, 2, 3, 4, error};
  run.picture = FileLabel(label) + ".png";
  run.map = FileLabel(label) + "-map.png";
  return run;
}

TEST(Comparison, MethodsSplitAtCommasAndOptionsStayWithTheirMethod) {
  EXPECT_THAT(SplitMethods("path,sdtree"), ElementsAre("path", "sdtree"));
  EXPECT_THAT(SplitMethods("sdtree:nee=always,combine=discard,path"),
              ElementsAre("sdtree:nee=always,combine=discard", "path"));
  EXPECT_THAT(SplitMethods("sdtree,nee=never,path"), ElementsAre("sdtree:nee=never", "path"));
  EXPECT_TRUE(SplitMethods("").empty());
}

TEST(Comparison, AListOfValuesIsNotTakenForMethods) {
  EXPECT_THAT(SplitMethods("path,auto:candidates=path/sdtree,pilot=1000,grid"),
              ElementsAre("path", "auto:candidates=path/sdtree,pilot=1000", "grid"));
  EXPECT_EQ(ParseMethodChoice("auto:candidates=path/sdtree,pilot=1000").options,
            (std::map<std::string, std::string>{{"candidates", "path,sdtree"}, {"pilot", "1000"}}));
  EXPECT_THAT(SplitMethods("path,auto:candidates=path"), ElementsAre("path", "auto:candidates=path"));
  EXPECT_THAT(SplitMethods("auto:candidates=path/sdtree,grid"), ElementsAre("auto:candidates=path/sdtree", "grid"));
  for (const char* text : {"path,auto:candidates=path,sdtree", "auto,candidates=path,sdtree:nee=always",
                           "auto:pilot=1000,candidates=path,sdtree,nee=always"}) {
    try {
      SplitMethods(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
      EXPECT_THAT(error.what(), HasSubstr("candidates=A/B")) << text;
    }
  }
}

TEST(Comparison, SpreadHasMedianAndSampleDeviation) {
  const Spread odd = SpreadOf({3, 1, 2});
  EXPECT_DOUBLE_EQ(odd.mean, 2);
  EXPECT_DOUBLE_EQ(odd.median, 2);
  EXPECT_DOUBLE_EQ(odd.deviation, 1);
  EXPECT_DOUBLE_EQ(odd.low, 1);
  EXPECT_DOUBLE_EQ(odd.high, 3);
  EXPECT_DOUBLE_EQ(SpreadOf({1, 2, 3, 10}).median, 2.5);
  EXPECT_DOUBLE_EQ(SpreadOf({5}).deviation, 0);
}

TEST(Comparison, RatioAndEfficiencyAreOfTheTrimmedError) {
  const auto methods = Summarize({RunOf("path", 0, 0.4, 10), RunOf("sdtree:nee=always", 0, 0.1, 10),
                                  RunOf("path", 1, 0.6, 10), RunOf("sdtree:nee=always", 1, 0.1, 10)});
  ASSERT_EQ(methods.size(), 2u);
  EXPECT_EQ(methods[0]["method"], "path");
  EXPECT_DOUBLE_EQ(methods[0]["ratio_to_first"], 1);
  EXPECT_DOUBLE_EQ(methods[1]["ratio_to_first"], 5);
  EXPECT_DOUBLE_EQ(methods[1]["efficiency"], 1);
  EXPECT_DOUBLE_EQ(methods[0]["relmse_trimmed"]["median"], 0.5);
  EXPECT_EQ(methods[0]["runs"].size(), 2u);
  EXPECT_EQ(methods[1]["runs"][1]["seed"], 1);
}

TEST(Comparison, WithoutAReferenceTheEstimateIsRanked) {
  ComparisonRun run = RunOf("path", 0, 0.4, 2);
  run.metrics.reset();
  const auto methods = Summarize({run});
  EXPECT_FALSE(methods[0].contains("relmse_trimmed"));
  EXPECT_DOUBLE_EQ(methods[0]["efficiency"], 1 / (9.0 * 2));
}

// Errors that fall as 1/sqrt(spp), at a second per 10 and per 20 samples: powers, which lie on lines of logarithms.
ComparisonRun Falling(const std::string& label, uint64_t seed, double error_of_one, double spp_per_second,
                      std::vector<uint64_t> spp) {
  ComparisonRun run = RunOf(label, seed, 1, 1);
  run.report.points.clear();
  for (const uint64_t s : spp) {
    const auto samples = static_cast<double>(s);
    run.report.points.push_back({.seconds = samples / spp_per_second,
                                 .spp = s,
                                 .relmse_estimated = 7,
                                 .against_reference = ErrorMetrics{1, 2, 3, 4, error_of_one / std::sqrt(samples)}});
  }
  run.metrics = run.report.points.back().against_reference;
  return run;
}

TEST(Comparison, AtEqualSamplesErrorsLieOnLinesOfLogarithms) {
  const std::vector<ComparisonRun> runs = {
      Falling("path", 0, 8, 20, {1, 30, 500}), Falling("sdtree", 0, 2, 10, {2, 64, 144}),
      Falling("path", 1, 16, 20, {100, 200}), Falling("sdtree", 1, 4, 10, {10, 250})};
  const auto equal = AtEqual(runs, EqualBy::kSamples);
  EXPECT_EQ(equal["by"], "spp");
  EXPECT_EQ(equal["at"], 144);
  const auto& path = equal["methods"][0];
  const auto& sdtree = equal["methods"][1];
  EXPECT_EQ(path["method"], "path");
  EXPECT_NEAR(path["error"]["low"], 8 / 12.0, 1e-12);
  EXPECT_NEAR(path["error"]["high"], 16 / 12.0, 1e-12);
  EXPECT_NEAR(path["error"]["median"], 1, 1e-12);
  EXPECT_NEAR(path["seconds"]["mean"], 7.2, 1e-12);
  EXPECT_NEAR(path["efficiency"], 1 / 7.2, 1e-12);
  EXPECT_DOUBLE_EQ(path["ratio_to_first"], 1);
  EXPECT_NEAR(sdtree["error"]["mean"], 3 / 12.0, 1e-12);
  EXPECT_NEAR(sdtree["seconds"]["mean"], 14.4, 1e-12);
  EXPECT_NEAR(sdtree["ratio_to_first"], 4, 1e-12);
}

TEST(Comparison, AtEqualTimeTheSlowerHasFewerSamples) {
  const auto equal =
      AtEqual({Falling("path", 0, 8, 20, {2, 100}), Falling("sdtree", 0, 2, 10, {2, 100})}, EqualBy::kTime);
  EXPECT_EQ(equal["by"], "seconds");
  EXPECT_EQ(equal["at"], 5);
  EXPECT_NEAR(equal["methods"][0]["error"]["mean"], 0.8, 1e-12);
  EXPECT_NEAR(equal["methods"][1]["spp"]["mean"], 50, 1e-9);
  EXPECT_NEAR(equal["methods"][1]["error"]["mean"], 2 / std::sqrt(50.0), 1e-12);
}

TEST(Comparison, WhatHasNoErrorThatEarlyHasNoPlaceAtEqualSamples) {
  // The estimate of one pass is not known: this run begins at two.
  ComparisonRun late = Falling("late", 0, 8, 20, {1, 200, 400}), early = Falling("early", 0, 8, 20, {1, 4});
  for (ErrorPoint& point : late.report.points) point.against_reference.reset();
  late.report.points[0].relmse_estimated = std::numeric_limits<double>::infinity();
  const auto equal = AtEqual({early, late}, EqualBy::kSamples);
  EXPECT_EQ(equal["at"], 4);
  EXPECT_DOUBLE_EQ(equal["methods"][0]["error"]["mean"], 4);
  EXPECT_TRUE(equal["methods"][1]["error"].is_null());
  EXPECT_TRUE(equal["methods"][1]["ratio_to_first"].is_null());
  late.report.points.resize(1);
  EXPECT_TRUE(AtEqual({early, late}, EqualBy::kSamples).is_null());
}

TEST(Comparison, ReportsShowEveryMethodAndEscapeWhatHtmlWouldRead) {
  nlohmann::json document = {{"scene", "a<b>.pbrt"},
                             {"command", "lodestar compare 'a<b>.pbrt'"},
                             {"reference", "ref.exr"},
                             {"plot", "compare-error.png"}};
  document["methods"] = Summarize({RunOf("path", 0, 0.4, 10), RunOf("sdtree", 0, 0.1, 10)});
  document["equal"] =
      AtEqual({Falling("path", 0, 8, 20, {100}), Falling("sdtree", 0, 2, 10, {100, 400})}, EqualBy::kSamples);
  const std::string markdown = MarkdownReport(document), html = HtmlReport(document);
  EXPECT_THAT(markdown, HasSubstr("| path "));
  EXPECT_THAT(markdown, HasSubstr("| sdtree "));
  EXPECT_THAT(markdown, HasSubstr("**Equal samples: 100 spp.**"));
  EXPECT_THAT(markdown, HasSubstr("\n| sdtree | 10 | 100 | 0.2 | 0.2 | 0.5 | 4 |\n"));
  EXPECT_THAT(html, HasSubstr("<b>Equal samples: 100 spp.</b>"));
  EXPECT_THAT(html, HasSubstr("<td>sdtree</td><td>10</td><td>100</td><td>0.2</td><td>0.2</td><td>0.5</td><td>4</td>"));
  EXPECT_THAT(markdown, HasSubstr("compare-error.png"));
  EXPECT_THAT(html, HasSubstr("sdtree-map.png"));
  EXPECT_THAT(html, HasSubstr("a&lt;b&gt;.pbrt"));
  EXPECT_THAT(html, Not(HasSubstr("a<b>")));
  document["plot"] = document["equal"] = nullptr;
  EXPECT_THAT(MarkdownReport(document), Not(HasSubstr("Equal samples")));
  EXPECT_THAT(MarkdownReport(document), Not(HasSubstr("compare-error.png")));
}

}  // namespace
}  // namespace lodestar
