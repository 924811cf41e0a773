// A render that meets a sample which is not a number one can add says so, and prints the command that gives that very
// sample again.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "tests/client/run_program.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

// A sky whose samples are numbers, but whose squares are not.
constexpr const char* kDazzling = "LightSource \"infinite\" \"rgb L\" [ 1e25 1e25 1e25 ]";

// The whole render, in this process; on its way it looks at the sample with the state that is in use.
class Onlooker final : public Executor {
 public:
  Onlooker(const CompiledJob& compiled, const JobSpec& job, const Method& method, const nlohmann::json& first)
      : compiled_(compiled), job_(job), method_(method), first_(first), local_(compiled.scene, job, method) {}
  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override {
    const uint32_t pass = first_["pass"];
    if (pass >= round.first_pass && pass < round.first_pass + round.passes) {
      EXPECT_EQ(round.iteration, first_["iteration"].get<uint32_t>());
      seen = PrepareTracer(compiled_.scene, job_, method_, state)
                 ->TraceSample(first_["pixel"][0], first_["pixel"][1], pass, round.record);
    }
    return local_.Execute(state, round, stop);
  }
  Rgb seen;

 private:
  const CompiledJob& compiled_;
  const JobSpec& job_;
  const Method& method_;
  const nlohmann::json first_;
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
  Onlooker onlooker(compiled, job, loop.method(), health["first"]);
  loop.Run(onlooker, StopToken(), {});
  EXPECT_EQ(sample["bits"], Bits(onlooker.seen));
}
INSTANTIATE_TEST_SUITE_P(Of, Health,
                         testing::Values(BadSample{"path", kBlindingLight, "infinite"},
                                         BadSample{"sdtree", kBlindingLight, "infinite"},
                                         BadSample{"path", kDazzling, "clamped"},
                                         BadSample{"sdtree", kDazzling, "clamped"}),
                         [](const auto& info) { return std::string(info.param.method) + "_" + info.param.event; });

}  // namespace
}  // namespace lodestar
