#include "client/values.h"

#include <gtest/gtest.h>

#include "client/suggest.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

TEST(Values, DurationsReadWithAndWithoutUnits) {
  EXPECT_DOUBLE_EQ(ParseDuration("90"), 90);
  EXPECT_DOUBLE_EQ(ParseDuration("60s"), 60);
  EXPECT_DOUBLE_EQ(ParseDuration("5m"), 300);
  EXPECT_DOUBLE_EQ(ParseDuration("5min"), 300);
  EXPECT_DOUBLE_EQ(ParseDuration("1h"), 3600);
  EXPECT_DOUBLE_EQ(ParseDuration("1h30m"), 5400);
  EXPECT_DOUBLE_EQ(ParseDuration("1.5m"), 90);
  EXPECT_DOUBLE_EQ(ParseDuration("250ms"), 0.25);
}

TEST(Values, WrongDurationsAreRefusedWithAnExample) {
  for (const char* text : {"", "s", "0", "0s", "-5s", "5 s", "5x", "1h30", "1e999", "nan", "inf", "60s "}) {
    try {
      ParseDuration(text);
      ADD_FAILURE() << "'" << text << "' was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
      EXPECT_NE(std::string(error.what()).find("e.g."), std::string::npos) << text;
    }
  }
}

TEST(Values, DurationsPrint) {
  EXPECT_EQ(FormatDuration(7), "0:07");
  EXPECT_EQ(FormatDuration(59.6), "1:00");
  EXPECT_EQ(FormatDuration(5025), "1:23:45");
  EXPECT_EQ(FormatDuration(-1), "-:--");
}

TEST(Values, Resolutions) {
  EXPECT_EQ(ParseResolution("640x360").x, 640u);
  EXPECT_EQ(ParseResolution("640x360").y, 360u);
  for (const char* text :
       {"", "640", "640x", "x360", "0x5", "5x0", "640X360", "-1x5", "70000x1", "5x5x5", "640 x 360"}) {
    EXPECT_THROW(ParseResolution(text), Error) << text;
  }
  EXPECT_EQ(ParsePixel("0,7").y, 7u);
  EXPECT_THROW(ParsePixel("3"), Error);
}

TEST(Values, CountsAndBytes) {
  EXPECT_EQ(FormatCount(12), "12");
  EXPECT_EQ(FormatCount(870e3), "870 k");
  EXPECT_EQ(FormatCount(3.214e6), "3.21 M");
  EXPECT_EQ(FormatBytes(1.5e9), "1.50 GB");
}

TEST(Values, WordsAreQuotedForAShellWhereTheyNeedIt) {
  EXPECT_EQ(ShellQuote("plain-word_1.exr"), "plain-word_1.exr");
  EXPECT_EQ(ShellQuote("two words"), "'two words'");
  EXPECT_EQ(ShellQuote("it's"), "'it'\\''s'");
  EXPECT_EQ(ShellQuote(""), "''");
}

TEST(Suggest, DistancesCountEdits) {
  EXPECT_EQ(EditDistance("spp", "spp"), 0);
  EXPECT_EQ(EditDistance("sppp", "spp"), 1);
  EXPECT_EQ(EditDistance("psp", "spp"), 1);
  EXPECT_EQ(EditDistance("", "abc"), 3);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3);
}

TEST(Suggest, OnlyNearWordsAreOffered) {
  const std::vector<std::string> words = {"--spp", "--seed", "--method", "--max-depth"};
  EXPECT_EQ(NearMatches("--sppp", words), std::vector<std::string>{"--spp"});
  EXPECT_EQ(NearMatches("--metod", words), std::vector<std::string>{"--method"});
  EXPECT_EQ(NearMatches("--max", words), std::vector<std::string>{"--max-depth"});
  EXPECT_TRUE(NearMatches("--entirely-else", words).empty());
  EXPECT_EQ(Suggestion("--sed", words), "; did you mean --seed?");
}

}  // namespace
}  // namespace lodestar
