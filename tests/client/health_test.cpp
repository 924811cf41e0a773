// A render that meets a sample which is not a number one can add says so, and prints the command that gives that very
// sample again.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

// A sky whose samples are numbers, but whose squares are not.
constexpr const char* kDazzling = "LightSource \"infinite\" \"rgb L\" [ 1e25 1e25 1e25 ]";

// The whole render, in this process; on its way it looks at samples with the state that is in use.
class Onlooker final : public Executor {
 public:
  // The pass of a round at which to look at the pixel, if any.
  using PassToSee = std::function<std::optional<uint32_t>(const std::shared_ptr<const State>&, const Round&)>;
  Onlooker(const CompiledJob& compiled, const JobSpec& job, const Method& method, uint32_t x, uint32_t y,
           PassToSee pass_to_see)
      : compiled_(compiled),
        job_(job),
        method_(method),
        x_(x),
        y_(y),
        pass_to_see_(std::move(pass_to_see)),
        local_(compiled.scene, job, method) {}
  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override {
    if (const auto pass = pass_to_see_(state, round)) {
      const Rgb radiance = PrepareTracer(compiled_.scene, job_, method_, state)->TraceSample(round, x_, y_, *pass);
      seen.push_back({round.iteration, *pass, radiance});
    }
    return local_.Execute(state, round, stop);
  }
  struct Seen {
    uint32_t iteration, pass;
    Rgb radiance;
  };
  std::vector<Seen> seen;

 private:
  const CompiledJob& compiled_;
  const JobSpec& job_;
  const Method& method_;
  uint32_t x_, y_;
  PassToSee pass_to_see_;
  LocalExecutor local_;
};

std::string Bits(Rgb c) {
  char text[96];
  std::snprintf(text, sizeof text, "%a %a %a", static_cast<double>(c.r), static_cast<double>(c.g),
                static_cast<double>(c.b));
  return text;
}

struct BadSample {
  const char *method, *light, *event;
};
void PrintTo(const BadSample& bad, std::ostream* out) {
  *out << bad.event << " in " << bad.method;
}

class Health : public testing::TestWithParam<BadSample> {};

TEST_P(Health, ThePrintedCommandReplaysTheSampleToTheBit) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("bright.pbrt", std::string(kPlainFloor) + GetParam().light);
  const Ran ran = RunLodestar(
      {"render", scene, "--method", GetParam().method, "--spp", "31", "--seed", "0", "-o", folder / "a.pfm", "--json"},
      {"LODESTAR_PLOT=/nonexistent"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto health = nlohmann::json::parse(ran.out)["health"];
  EXPECT_GT(health["counts"][GetParam().event], 0) << health;
  ASSERT_EQ(health["first"]["event"], GetParam().event) << health;
  const std::string command = health["replay"];
  ASSERT_TRUE(command.starts_with("lodestar replay ")) << command;

  // As the user would: in a shell that finds the program.
  const Ran replayed =
      RunProgram({"sh", "-c", "PATH=\"$(dirname '" LODESTAR_PROGRAM "'):$PATH\"; " + command + " --json"});
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const auto sample = nlohmann::json::parse(replayed.out);
  EXPECT_EQ(sample["event"], GetParam().event);
  const bool infinite = GetParam().event == std::string("infinite");
  EXPECT_EQ(sample["bits"].get<std::string>().find("inf") != std::string::npos, infinite) << sample;

  JobSpec job;
  job.method = GetParam().method;
  job.budget.spp = 31;
  const CompiledJob compiled = CompileJob(ParsePbrtFile(scene), job);
  Loop loop(job, compiled.survey);
  const nlohmann::json& first = health["first"];
  const uint32_t pass = first["pass"];
  Onlooker onlooker(compiled, job, loop.method(), first["pixel"][0], first["pixel"][1],
                    [&](const auto&, const Round& round) -> std::optional<uint32_t> {
                      if (pass < round.first_pass || pass >= round.first_pass + round.passes) return std::nullopt;
                      return pass;
                    });
  loop.Run(onlooker, StopToken(), {});
  ASSERT_EQ(onlooker.seen.size(), 1u);
  EXPECT_EQ(first["iteration"], onlooker.seen[0].iteration);
  EXPECT_EQ(sample["bits"], Bits(onlooker.seen[0].radiance));
}
INSTANTIATE_TEST_SUITE_P(Of, Health,
                         testing::Values(BadSample{"path", kBlindingLight, "infinite"},
                                         BadSample{"sdtree", kBlindingLight, "infinite"},
                                         BadSample{"path", kDazzling, "clamped"},
                                         BadSample{"sdtree", kDazzling, "clamped"}),
                         [](const auto& info) { return std::string(info.param.method) + "_" + info.param.event; });

// `auto` begins with a candidate that learns nothing, whose state is not that of the iterations to come.
TEST(Replay, OfAMethodThatChoosesIsUnderTheStateOfItsIteration) {
  TemporaryFolder folder;
  const std::string scene = folder.Write("tiny.pbrt", kTinyScene);
  JobSpec job;
  job.method = "auto";
  job.options = {{"candidates", "path,sdtree"}, {"pilot", "1000"}};
  job.budget.spp = 200;
  const CompiledJob compiled = CompileJob(ParsePbrtFile(scene), job);
  Loop loop(job, compiled.survey);
  Onlooker onlooker(compiled, job, loop.method(), 8, 9,
                    [&](const auto& state, const Round& round) -> std::optional<uint32_t> {
                      if (loop.method().ActiveUnder(state).candidate == 0) return std::nullopt;
                      return round.first_pass + round.passes - 1;
                    });
  loop.Run(onlooker, StopToken(), {});
  ASSERT_GE(onlooker.seen.size(), 2u) << "rounds of a guided candidate";
  for (const auto& seen : onlooker.seen) {
    ASSERT_GE(seen.iteration, 1u);
    const Ran ran = RunLodestar({"replay", scene, "--method", "auto", "--option", "candidates=path,sdtree", "--option",
                                 "pilot=1000", "--spp", "200", "--pixel", "8,9", "--pass", std::to_string(seen.pass),
                                 "--iteration", std::to_string(seen.iteration), "--json"});
    ASSERT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(nlohmann::json::parse(ran.out)["bits"], Bits(seen.radiance))
        << "pass " << seen.pass << " of iteration " << seen.iteration;
  }
}

}  // namespace
}  // namespace lodestar
