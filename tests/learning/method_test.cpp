#include "core/learning/method.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/guiding/sd_tree_advance.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/method_options.h"
#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"
#include "tests/guiding/grid_testing.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

using test::SyntheticSurvey;

std::string Refusal(const std::string& method, std::map<std::string, std::string> options) {
  JobSpec job;
  job.method = method;
  job.options = std::move(options);
  try {
    MakeMethod(job, SyntheticSurvey());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
    return error.what();
  }
  return "accepted";
}

TEST(Registry, NamesItsMethods) {
  ASSERT_EQ(Methods().size(), 6u);
  for (const MethodEntry& entry : Methods()) {
    EXPECT_FALSE(entry.summary.empty());
    JobSpec job;
    job.method = entry.name;
    EXPECT_EQ(MakeMethod(job, SyntheticSurvey())->name(), entry.name);
    for (const OptionHelp& option : entry.options) {
      EXPECT_FALSE(option.values.empty() || option.default_value.empty() || option.help.empty())
          << entry.name << " " << option.name;
    }
  }
}

TEST(Registry, UnknownNamesListWhatExists) {
  EXPECT_EQ(Refusal("sdtre", {}),
            "there is no method 'sdtre'; there are: path, sdtree, focal, grid, sdtree+focal, auto");
  EXPECT_EQ(Refusal("path", {{"net", "always"}}), "method 'path' has no option 'net'; it has: nee");
  EXPECT_NE(Refusal("sdtree", {{"combination", "discard"}}).find("it has: preset, nee, lights, target, "),
            std::string::npos);
}

TEST(Registry, BadValuesListWhatIsTaken) {
  EXPECT_EQ(Refusal("path", {{"nee", "kickstart"}}),
            "option 'nee' of method 'path' cannot be 'kickstart'; it takes always | never");
  for (const auto& [name, value] : std::map<std::string, std::string>{{"preset", "2018"},
                                                                      {"nee", ""},
                                                                      {"combine", "best"},
                                                                      {"spatial-filter", "Nearest"},
                                                                      {"directional-filter", "stochastic"},
                                                                      {"bsdf-fraction", "0.01"},
                                                                      {"spatial-threshold", "0"},
                                                                      {"flux-threshold", "nan"},
                                                                      {"max-depth", "20.5"},
                                                                      {"training", "-1"}}) {
    const std::string refusal = Refusal("sdtree", {{name, value}});
    EXPECT_NE(refusal.find("option '" + name + "' of method 'sdtree' cannot be '" + value + "'; it takes "),
              std::string::npos)
        << refusal;
  }
}

TEST(Registry, EveryDocumentedChoiceIsTaken) {
  for (const MethodEntry& entry : Methods()) {
    for (const OptionHelp& option : entry.options) {
      size_t at = 0;
      while (at != std::string::npos) {
        const size_t bar = option.values.find(" | ", at);
        const std::string value = option.values.substr(at, bar == std::string::npos ? bar : bar - at);
        at = bar == std::string::npos ? bar : bar + 3;
        if (value.find(' ') != std::string::npos) continue;  // "a number from ..."
        EXPECT_EQ(Refusal(entry.name, {{option.name, value}}), "accepted") << option.name << "=" << value;
      }
    }
  }
}

TEST(Nee, KickstartEndsAfterThreeIterations) {
  EXPECT_TRUE(UsesNee(NeeMode::kKickstart, 0));
  EXPECT_TRUE(UsesNee(NeeMode::kKickstart, 2));
  EXPECT_FALSE(UsesNee(NeeMode::kKickstart, 3));
  EXPECT_TRUE(UsesNee(NeeMode::kAlways, 100));
  EXPECT_FALSE(UsesNee(NeeMode::kNever, 0));
}

TEST(SdTreeMethod, IterationsDouble) {
  const auto method = MakeMethod(test::SyntheticJob("sdtree", 1), SyntheticSurvey());
  const auto state = method->Initial();
  EXPECT_EQ(method->IterationPasses(*state, 0), 1u);
  EXPECT_EQ(method->IterationPasses(*state, 6), 64u);
  EXPECT_EQ(method->IterationPasses(*state, 70), uint64_t{1} << 32);
}

TEST(SdTreeMethod, EmptySceneBoundsAreRefused) {
  Survey survey = SyntheticSurvey();
  survey.bounds = Bounds3();
  EXPECT_THROW(MakeMethod(test::SyntheticJob("sdtree", 1), survey)->Initial(), Error);
}

// Of a state that another job made.
void ExpectForeign(const JobSpec& job, const Survey& survey, std::string_view state, ErrorKind kind,
                   const std::string& message) {
  try {
    SdTreeMethod(job, survey).ParseState(state);
    FAIL() << "was read";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind);
    EXPECT_EQ(error.what(), message);
  }
}

TEST(SdTreeMethod, StatesOfOtherOptionsAreRefused) {
  JobSpec job = test::SyntheticJob("sdtree", 1);
  const Bytes state = SdTreeMethod(job, SyntheticSurvey()).Initial()->Serialize();
  EXPECT_NO_THROW(SdTreeMethod(job, SyntheticSurvey()).ParseState(state));
  job.options["flux-threshold"] = "0.02";
  ExpectForeign(job, SyntheticSurvey(), state, ErrorKind::kConflict,
                "a guiding state was made with other options than its job's; submit the job again");
}

TEST(Registry, StatesOfOtherOptionsAreRefused) {
  struct Case {
    std::string method, option, value, part;
  };
  for (const Case& c : {Case{"focal", "start-depth", "4", "focal"}, Case{"grid", "cells", "4", "grid"},
                        Case{"sdtree+focal", "start-depth", "4", "focal"}}) {
    JobSpec job = test::SyntheticJob(c.method, 1);
    const Bytes state = MakeMethod(job, SyntheticSurvey())->Initial()->Serialize();
    EXPECT_NO_THROW(MakeMethod(job, SyntheticSurvey())->ParseState(state));
    job.options[c.option] = c.value;
    try {
      MakeMethod(job, SyntheticSurvey())->ParseState(state);
      ADD_FAILURE() << c.method << ": was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kConflict);
      EXPECT_EQ(error.what(),
                "a " + c.part + " guiding state was made with other options than its job's; submit the job again");
    }
  }
}

TEST(SdTreeMethod, StatesOfOtherLightsAreRefused) {
  const JobSpec job = test::SyntheticJob("sdtree", 1);
  Survey survey = SyntheticSurvey();
  survey.light_groups = {0.25f, 0.75f};
  const Bytes state = SdTreeMethod(job, survey).Initial()->Serialize();
  EXPECT_NO_THROW(SdTreeMethod(job, survey).ParseState(state));
  for (const std::vector<float>& others : {std::vector<float>{0.5f, 0.5f}, {0.25f, 0.25f, 0.5f}, {}}) {
    survey.light_groups = others;
    ExpectForeign(job, survey, state, ErrorKind::kConflict,
                  "a guiding state was made for other lights than its job's; submit the job again");
  }
}

TEST(SdTreeMethod, StatesOfOtherImagesAreRefused) {
  JobSpec job = test::SyntheticJob("sdtree", 1);
  job.options["target"] = "full";
  const SdTreeMethod method(job, SyntheticSurvey(4, 2));
  // The second iteration's target needs an estimate of the pixels.
  const auto tree = SdTree::Initial(SyntheticSurvey().bounds, method.options().tree);
  const auto later = Advance(*tree, SdTreeStatistics(tree), 1);
  const PixelEstimate pixels{4, 2, std::vector<float>(8, 1)};
  EXPECT_NO_THROW(method.ParseState(SdTreeState(later, pixels).Serialize()));
  EXPECT_NO_THROW(method.ParseState(SdTreeState(tree, {}).Serialize()));
  const std::string message = "a guiding state has a pixel estimate of another size than its job's image";
  ExpectForeign(job, SyntheticSurvey(2, 4), SdTreeState(later, pixels).Serialize(), ErrorKind::kCorrupt, message);
  ExpectForeign(job, SyntheticSurvey(4, 3), SdTreeState(tree, pixels).Serialize(), ErrorKind::kCorrupt, message);
  ExpectForeign(job, SyntheticSurvey(4, 2), SdTreeState(later, {}).Serialize(), ErrorKind::kCorrupt, message);
}

TEST(GridMethod, MemoSaysThatItIsBiased) {
  const auto explain = [](const std::string& sampling, bool learned) {
    JobSpec job;
    job.method = "grid";
    job.options["sampling"] = sampling;
    const GridMethod method(job, SyntheticSurvey());
    auto grid = RadianceGrid::Initial(SyntheticSurvey().bounds, method.options().grid);
    if (learned) grid = grid_testing::Train(method.options().grid);
    return method.Explain(GridState(grid));
  };
  for (const char* sampling : {"rejection-memo", "rejection-mixed-memo"}) {
    EXPECT_NE(explain(sampling, true).find("BIASED, as its densities integrate to "), std::string::npos);
    EXPECT_TRUE(explain(sampling, false).ends_with("BIASED"));
  }
  EXPECT_EQ(explain("rejection", true), "");
}

// More exploration than steps would never guide.
TEST(GridMethod, GuidesAfterItsLastStep) {
  JobSpec job = test::SyntheticJob("grid", 64);
  job.options["exploration"] = "5";
  const GridMethod automatic(job, SyntheticSurvey());
  EXPECT_EQ(automatic.options().steps, 2u);
  EXPECT_EQ(automatic.options().exploration, 2u);
  // As decided, also in a replay that has another budget.
  job.options = automatic.DecidedOptions(*automatic.Initial());
  job.budget = {.spp = 1000};
  const GridMethod replay(job, SyntheticSurvey());
  EXPECT_EQ(replay.options().steps, 2u);
  EXPECT_EQ(replay.options().exploration, 2u);
  EXPECT_EQ(
      Refusal("grid", {{"steps", "4"}, {"exploration", "5"}}),
      "option 'exploration' of method 'grid' cannot be '5'; it takes an integer from 1 to 1000, no more than steps");
  EXPECT_EQ(Refusal("grid", {{"steps", "5"}, {"exploration", "5"}}), "accepted");
  EXPECT_EQ(Refusal("grid", {{"steps", "0"}, {"exploration", "5"}}), "accepted");  // nothing is learned
}

TEST(PathMethod, HasNothingToLearn) {
  const auto method = MakeMethod(test::SyntheticJob("path", 1), SyntheticSurvey());
  const auto state = method->Initial();
  EXPECT_TRUE(state->Serialize().empty());
  EXPECT_NO_THROW(method->ParseState(""));
  EXPECT_THROW(method->ParseState("x"), Error);
  EXPECT_EQ(method->NewStatistics(state), nullptr);
  std::unique_ptr<Statistics> none;
  EXPECT_THROW(AddStatistics(*method, state, "", &none), Error);
  EXPECT_EQ(method->IterationPasses(*state, 3), 0u);
}

TEST(MethodOptions, NumbersAreWholeAndFinite) {
  double value = 0;
  EXPECT_TRUE(ParseNumber("0.25", &value));
  EXPECT_EQ(value, 0.25);
  EXPECT_TRUE(ParseNumber("-1e3", &value));
  for (const char* text : {"", "1 ", " 1", "0x10", "1,5", "inf", "nan", "1e999", "one"})
    EXPECT_FALSE(ParseNumber(text, &value)) << text;
}

}  // namespace
}  // namespace lodestar
