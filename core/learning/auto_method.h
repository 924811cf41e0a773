// `auto`: measures which method renders this image most efficiently, and leaves the others out
// (docs/decisions/0013-auto.md).
//
// The candidates are other methods, each with a state and a learning half of its own. In the pilot each renders a few
// iterations of the job's image; what they render enters the image by inverse variance. Then the most promising goes
// on, training further if it wants to. A method that learns is judged by its last film and by how much better that was
// than the one before; one that leads by that promise alone is on probation and is measured again after every
// iteration. Costs are counted in rays and vertices, never in seconds, so the choice is the same on any machine, with
// any number of workers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/learning/method.h"
#include "core/learning/race.h"

namespace lodestar {

class AutoState final : public State {
 public:
  struct Parts {
    uint32_t active = 0;                               // the candidate that renders under this state
    bool settled = false;                              // the race is over
    bool decided = false;                              // and there is nothing more to learn
    std::vector<std::shared_ptr<const State>> states;  // by candidate; null: dropped
    std::vector<double> work;                          // of the iterations so far, in rays; until the race is over
    std::vector<PilotResult> results;                  // in the order they were rendered; once the pilot is over
  };
  explicit AutoState(Parts parts) : parts_(std::move(parts)) {}
  const Parts& parts() const { return parts_; }
  Bytes Serialize() const override;

 private:
  Parts parts_;
};

class AutoMethod final : public Method {
 public:
  AutoMethod(const JobSpec& job, const Survey& survey);
  static MethodEntry Entry();

  // The method that renders under a state of this one, and its own state.
  const Method& ActiveMethod(const State& state) const;
  std::shared_ptr<const State> ActiveState(const State& state) const;

  std::string_view name() const override { return "auto"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override;
  std::unique_ptr<Statistics> ParseStatistics(const std::shared_ptr<const State>& state,
                                              std::string_view bytes) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(uint32_t iteration) const override;
  bool Decided(const State& state) const override;
  std::string Explain(const State& state) const override;
  // All iterations count: a pilot is no worse than any other film of its variance.
  Combination combination() const override { return {Combination::Kind::kInverseVariance, 32}; }

 private:
  struct Candidate {
    std::unique_ptr<Method> method;
    double vertex_work;           // of shading a vertex, in rays
    std::vector<uint64_t> pilot;  // passes of its pilot iterations; the last two are measured
  };
  // The candidate and its own iteration that iteration k of the pilot belongs to.
  struct Turn {
    uint32_t candidate = 0, iteration = 0;
    bool measured = false;
  };
  Turn TurnOf(uint32_t iteration) const;  // of the pilot
  uint32_t PilotIterations() const;
  std::vector<PilotResult> Measure(const IterationResult& result, const AutoState::Parts& parts) const;
  // Sets active, settled and the states that are left.
  void Decide(AutoState::Parts* parts) const;
  uint32_t Winner(const std::vector<PilotResult>& results) const;

  std::vector<Candidate> candidates_;
};

}  // namespace lodestar
