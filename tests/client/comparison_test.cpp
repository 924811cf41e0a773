#include "client/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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

TEST(Comparison, ReportsShowEveryMethodAndEscapeWhatHtmlWouldRead) {
  nlohmann::json document = {{"scene", "a<b>.pbrt"},
                             {"command", "lodestar compare 'a<b>.pbrt'"},
                             {"reference", "ref.exr"},
                             {"plot", "compare-error.png"}};
  document["methods"] = Summarize({RunOf("path", 0, 0.4, 10), RunOf("sdtree", 0, 0.1, 10)});
  const std::string markdown = MarkdownReport(document), html = HtmlReport(document);
  EXPECT_THAT(markdown, HasSubstr("| path "));
  EXPECT_THAT(markdown, HasSubstr("| sdtree "));
  EXPECT_THAT(markdown, HasSubstr("compare-error.png"));
  EXPECT_THAT(html, HasSubstr("sdtree-map.png"));
  EXPECT_THAT(html, HasSubstr("a&lt;b&gt;.pbrt"));
  EXPECT_THAT(html, Not(HasSubstr("a<b>")));
  document["plot"] = nullptr;
  EXPECT_THAT(MarkdownReport(document), Not(HasSubstr("compare-error.png")));
}

}  // namespace
}  // namespace lodestar
