#include "client/job_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "core/base/error.h"

namespace lodestar {
namespace {

JobSpec Parse(const std::string& line) {
  CLI::App app;
  JobArguments arguments;
  AddJobOptions(app, arguments);
  app.parse(line);
  return arguments.ToJob();
}

std::string Refusal(const std::string& line) {
  try {
    Parse(line);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(JobOptions, EveryOptionReachesTheJob) {
  const JobSpec job = Parse(
      "s.pbrt --method path --spp 64 --time 1m30s --error 0.02 --resolution 64x48 --filter box --max-depth 7 --seed 11 "
      "--option nee=never");
  EXPECT_EQ(job.method, "path");
  EXPECT_EQ(job.budget.spp, 64u);
  EXPECT_EQ(job.budget.seconds, 90);
  EXPECT_EQ(job.budget.error, 0.02);
  EXPECT_EQ(job.resolution_x, 64u);
  EXPECT_EQ(job.resolution_y, 48u);
  EXPECT_EQ(job.filter, "box");
  EXPECT_EQ(job.max_depth, 7);
  EXPECT_EQ(job.seed, 11u);
  EXPECT_EQ(job.options.at("nee"), "never");
}

TEST(JobOptions, EveryOptionOfEveryMethodIsDocumentedAndAFlag) {
  CLI::App app;
  JobArguments arguments;
  AddJobOptions(app, arguments);
  const std::string help = app.help();
  ASSERT_FALSE(Methods().empty());
  for (const MethodEntry& method : Methods()) {
    EXPECT_THAT(help, testing::HasSubstr(method.name));
    for (const OptionHelp& option : method.options) {
      // Where a render option has the name already, the method's name stands in front.
      const std::string flag = option.name == "max-depth" ? "--" + method.name + "-max-depth" : "--" + option.name;
      EXPECT_NE(app.get_option_no_throw(flag), nullptr) << flag;
      EXPECT_THAT(help, testing::HasSubstr(flag));
      EXPECT_THAT(help, testing::HasSubstr("[" + option.default_value + "]"));
    }
  }
}

TEST(JobOptions, AMethodsMaxDepthIsNotThePaths) {
  const JobSpec job = Parse("s.pbrt --method sdtree --max-depth 7 --sdtree-max-depth 12");
  EXPECT_EQ(job.max_depth, 7);
  EXPECT_EQ(job.options.at("max-depth"), "12");
}

TEST(JobOptions, AFlagOfAMethodIsItsOption) {
  EXPECT_EQ(Parse("s.pbrt --method path --nee never").options.at("nee"), "never");
  EXPECT_TRUE(Parse("s.pbrt --method path").options.empty());
}

TEST(JobOptions, UnknownMethodsAndOptionsNameWhatThereIs) {
  EXPECT_THAT(Refusal("s.pbrt --method sdtre"),
              testing::AllOf(testing::HasSubstr("did you mean sdtree"), testing::HasSubstr("path")));
  EXPECT_THAT(Refusal("s.pbrt --method sdtree --option nees=always"), testing::HasSubstr("did you mean nee"));
  EXPECT_THAT(Refusal("s.pbrt --method sdtree --option nee"), testing::HasSubstr("NAME=VALUE"));
  EXPECT_THAT(Refusal("s.pbrt --method path --combine discard"), testing::HasSubstr("'path' has no option 'combine'"));
}

TEST(JobOptions, ValuesOutOfRangeAreRefused) {
  for (const char* line : {"s.pbrt --spp 0", "s.pbrt --spp -3", "s.pbrt --spp x", "s.pbrt --error 0",
                           "s.pbrt --error -1", "s.pbrt --time 0", "s.pbrt --time x", "s.pbrt --resolution 5",
                           "s.pbrt --filter sinc", "s.pbrt --max-depth 0", "s.pbrt --seed -1", "--spp 4"}) {
    EXPECT_NE(Refusal(line), "") << line;
  }
}

TEST(JobOptions, AMethodMayCarryItsOptions) {
  const MethodChoice plain = ParseMethodChoice("path");
  EXPECT_EQ(plain.method, "path");
  EXPECT_TRUE(plain.options.empty());
  const MethodChoice choice = ParseMethodChoice("sdtree:nee=always,combine=discard");
  EXPECT_EQ(choice.method, "sdtree");
  EXPECT_EQ(choice.label, "sdtree:nee=always,combine=discard");
  EXPECT_EQ(choice.options.at("nee"), "always");
  EXPECT_EQ(choice.options.at("combine"), "discard");
  EXPECT_THROW(ParseMethodChoice("sdtree:"), Error);
  EXPECT_THROW(ParseMethodChoice("sdtree:nee"), Error);
  EXPECT_THROW(ParseMethodChoice("sdtree:other=1"), Error);
  EXPECT_THROW(ParseMethodChoice("other"), Error);
}

}  // namespace
}  // namespace lodestar
