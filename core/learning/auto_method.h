// `auto`: measures which method renders this image most efficiently, and leaves the others out
// (docs/decisions/0013-auto.md).
//
// The candidates are other methods, each with a state and a learning half of its own. In the pilot each renders a few
// iterations of the job's image; what they render enters the image by inverse variance. A candidate may need a reason
// to be looked at: light that the first, path tracing, hardly finds. Then the most promising goes on, training further
// if it wants to. A method that learns is judged by its last film and by how much better that was than the one before;
// one that leads by that promise alone is on probation and is measured again after every iteration. Costs are counted
// in rays and vertices, never in seconds, so the choice is the same on any machine, with any number of workers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/learning/method.h"
#include "core/learning/race.h"

namespace lodestar {

class AutoState final : public State {
 public:
  struct Entrant {
    // Null: dropped, as the candidate has lost for good or is not tried. Those that may still render have theirs.
    std::shared_ptr<const State> state;
    uint32_t iterations = 0;               // that it rendered
    uint64_t passes = 0, last_passes = 0;  // of all of them, and of the last
  };
  static constexpr uint32_t kNever = ~uint32_t{0};
  struct Parts {
    uint32_t active = 0;               // the candidate that renders under this state
    bool settled = false;              // the race is over
    uint32_t late_from = kNever;       // iterations that were over when it had become late to try what may grow
    std::vector<Entrant> entrants;     // by candidate
    std::vector<PilotResult> results;  // in the order they were rendered; once the pilot is over
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

  std::string_view name() const override { return "auto"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State& state, uint32_t iteration) const override;
  Active ActiveUnder(const std::shared_ptr<const State>& state) const override;
  uint32_t candidates() const override { return static_cast<uint32_t>(candidates_.size()); }
  bool Decided(const State& state) const override;
  std::map<std::string, std::string> DecidedOptions(const State& state) const override;
  std::string Explain(const State& state) const override;

 private:
  struct Candidate {
    const char* name;
    std::unique_ptr<Method> method;
    double vertex_work;         // of shading a vertex, in rays
    uint32_t pilot_iterations;  // its pilot has at least so many, unless it is hopeless before, ...
    uint64_t pilot_passes;      // ... and so many passes
    double worth_above;         // looked at only where the first film's RelativeVariance is at least this
  };
  using Parts = AutoState::Parts;

  // Passes of the candidate's own next iteration once `ahead` more are done; 0: it has nothing to learn any more.
  uint64_t OwnPasses(const Parts& parts, uint32_t candidate, uint32_t ahead = 0) const;
  // Passes of the next iteration of its pilot; 0: the pilot is over.
  uint64_t PilotPasses(const Parts& parts, uint32_t candidate) const;
  using Results = std::vector<PilotResult>;
  // Of the last two films of each candidate, those that tell a variance.
  Results Measure(const IterationResult& result) const;
  // The candidate whose pilot comes next; the number of candidates where there is none.
  uint32_t NextInPilot(const Parts& parts, const IterationResult& result, const Results& measured, bool hopeless) const;
  // By how much the candidate may be better at the end of its pilot, and one iteration later, than it is now.
  double MostGrowth(const Parts& parts, const Results& measured, uint32_t candidate) const;
  // Whether the candidate, in its pilot or before it, is so far behind one that came before that it will not be ahead
  // at its end. It is lost for good then.
  bool Hopeless(const Parts& parts, const Results& measured, uint32_t candidate) const;
  // How much better the candidate's next films may be than its last.
  double Promise(const Parts& parts, uint32_t candidate) const;
  // After the pilots: sets active, settled and the states that are left. `last`: this is final.
  void Decide(Parts* parts, bool last) const;
  // Among those that are not dropped.
  uint32_t Winner(const Parts& parts) const;

  int credit_;  // iterations before it is late; -1: as the loop says
  std::vector<Candidate> candidates_;
  std::vector<std::string> not_needed_;  // candidates that the scene has nothing for
};

}  // namespace lodestar
