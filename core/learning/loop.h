// The loop: state -> rounds -> merge -> advance, written once. It takes an executor (threads of this process, or leases
// of the farm), decides stops at round edges, accumulates the image, and records error against run time. Its whole
// position can be checkpointed and restored.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/clock.h"
#include "core/base/hash.h"
#include "core/base/stop.h"
#include "core/film/error_metrics.h"
#include "core/learning/combination.h"
#include "core/learning/method.h"

namespace lodestar {

// Renders rounds. Implementations: tracing/LocalExecutor, coordinator/FarmExecutor.
class Executor {
 public:
  virtual ~Executor() = default;
  // Blocks until every unit of the round is merged; nothing where `stop` was requested first.
  virtual std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                              const StopToken& stop) = 0;
  // Called before Execute(state, round): the round that would come after it under the same state, if no budget ends the
  // run first. An executor may begin it while `round` drains, and must be ready to throw it away. The loop leaves this
  // out where the state will advance in between.
  virtual void Announce(const std::shared_ptr<const State>& state, const Round& next) {}
  // Who shares in advancing the state; null: nobody.
  virtual ShardRunner* shards() { return nullptr; }
};

// One point of error against run time.
struct ErrorPoint {
  double seconds = 0;
  uint64_t spp = 0;  // passes rendered so far, training included
  uint32_t iteration = 0;
  double relmse_estimated = 0;  // trimmed, from the pixel variances; infinity while unknown (one pass)
  std::optional<ErrorMetrics> against_reference;
};

struct JobReport {
  JobSpec job;
  Survey survey;
  std::vector<ErrorPoint> points;
  HealthReport health;
  uint64_t passes = 0;
  uint32_t iterations = 0;
  int training_iterations = 0;  // with `passes`, what a replay needs
  double seconds = 0, seconds_learning = 0;
  uint64_t rays = 0, paths = 0, vertices = 0;
  std::string stop_reason;  // "spp", "time", "error", "stopped"
  std::string choice;       // what the method chose and left out (Method::Explain)
  // Where the run ended (FinalReport; empty before): SHA-256 of the state's bytes, and of the image's floats
  // (ImageHash).
  ContentHash state_hash, image_hash;
};

// Of the raw floats, little-endian, row by row from the top: R, G, B of all pixels, then the variances of all pixels.
ContentHash ImageHash(const Image& image);

// Makes the method of a job; a loop takes another than MakeMethod where tests or research bring their own.
using MethodFactory = std::function<std::unique_ptr<Method>(const JobSpec&, const Survey&)>;

// Iterations. Those before the last train: they have as many passes as the method says, and what they recorded advances
// the state. The last one only renders and takes what the budget still gives. When training ends is decided at
// iteration ends and stored: after JobSpec::training_iterations, or the method's own number; else when the next
// iteration would leave less than half of the budget to the last one (by spp, also where less than the next two
// doublings together is left; by time and error: predicted; what losers of a race took comes on top); and for
// Combination::kAutomatic once the predicted final variance stops falling (Mueller et al. 2017, section 5.3).
class Loop {
 public:
  struct Hooks {
    std::function<void(const JobProgress&)> progress = {};  // after each round
    std::shared_ptr<const Image> reference = {};            // error points are measured against it where given
    // At each advance: the state that ends, what was learned under it (null: nothing), and the one that comes.
    std::function<void(const std::shared_ptr<const State>&, const Statistics*, const std::shared_ptr<const State>&)>
        advanced = {};
  };

  // Throws Error(kInvalidInput) for budgets, resolutions, methods and options that make no sense.
  Loop(const JobSpec& job, const Survey& survey, const MethodFactory& make_method = MakeMethod);
  // Bytes of the films that a loop of this job may hold at a time (of one candidate, where its method tries several).
  // Throws as the constructor does, and takes none of that memory.
  static uint64_t FilmBytes(const JobSpec& job, const Survey& survey);
  // From Checkpoint(); throws Error(kCorrupt) or (kConflict) on bytes of another version.
  static std::unique_ptr<Loop> Restore(std::string_view checkpoint);

  // Runs to the budget or to a stop request (which leaves the loop at the last round's edge; Run() again goes on from
  // there). Time is the executor's by `clock`, merging and advancing included, hooks and error measurement not. What
  // the executor or a hook throws passes through, with the loop at the last edge.
  void Run(Executor& executor, const StopToken& stop, const Hooks& hooks, const Clock& clock = Clock::Steady());

  Image Develop() const;  // the image so far; black before the first round
  JobReport Report() const;
  Bytes Checkpoint() const;
  bool finished() const { return finished_; }
  const Method& method() const { return *method_; }
  const std::shared_ptr<const State>& state() const { return state_; }
  const JobSpec& job() const { return job_; }
  const Survey& survey() const { return survey_; }
  const TileGrid& grid() const { return grid_; }
  uint64_t passes() const { return passes_; }
  // The round Run() would execute next (or is executing); not once finished.
  Round NextRound() const;

 private:
  friend class LoopCheckpoint;

  uint64_t SppBudget() const;
  // The round at a position; `done` passes of its iteration and `passes` of the job lie before it.
  Round RoundAt(uint32_t iteration, uint32_t index, bool final, uint64_t done, uint64_t passes) const;
  std::optional<Round> RoundAfter(const Round& round) const;  // under the same state
  bool TimeBudgetOver(double next_round_seconds) const;
  // Round edges.
  void AddRound(const Round& round, Contribution contribution);
  void DecideStop(const Round& round, double round_seconds, const Image* reference);
  void Measure(const Image* reference);
  JobProgress Progress(double seconds_per_pass) const;
  // Iteration ends.
  bool EndsTraining(uint32_t next) const;
  // Seconds of the run when that many more passes are done, each as long as this iteration's.
  double PredictedEnd(uint64_t passes) const;
  // Of the run, that other candidates took than the current iteration's.
  double SecondsOfOthers() const;
  // That the image must have for the budget's error; infinity where that is not known.
  double PassesForError() const;
  // Share of the budget that is spent when iteration `next` is over.
  double SpentAfter(uint32_t next) const;
  double PredictedVariance() const;
  void Advance(ShardRunner* shards, const Hooks& hooks, const Clock& clock);
  void BeginIteration();

  JobSpec job_;
  Survey survey_;
  TileGrid grid_;
  std::unique_ptr<Method> method_;
  std::shared_ptr<const State> state_;
  std::vector<IterationFilm> films_;       // those that still can enter the image; the last is the current iteration's
  std::unique_ptr<Statistics> learned_;    // of the current iteration, rounds merged
  std::optional<CombinedFilms> combined_;  // at an iteration's end, as measured: for what is decided there
  uint32_t iteration_ = 0, round_ = 0;
  uint64_t iteration_passes_ = 0, passes_ = 0;
  bool final_iteration_ = false;
  bool iteration_complete_ = false;  // the advance comes next, and what the next iteration is has been decided
  bool next_is_final_ = false, next_is_late_ = false, finished_ = false;
  double seconds_ = 0, seconds_learning_ = 0;
  double iteration_seconds_ = 0, last_advance_seconds_ = 0;
  double previous_prediction_ = 0;  // Combination::kAutomatic; 0: none yet
  double error_ = 0;                // last measured estimate; infinity: unknown
  JobReport report_;                // points, health, counters and stop reason; Report() adds the rest
};

// The report of a run that has ended, hashes included; `image` is what it has developed. Two runs of one job that ended
// after as many passes and training iterations, neither stopped by hand, have the same hashes, wherever they ran.
JobReport FinalReport(const Loop& loop, const Image& image);

// Passes in a round: enough samples that a round's overhead vanishes and few enough that budgets by time are met
// closely; a function of the resolution and of whether the round records.
uint32_t PassesPerRound(uint32_t width, uint32_t height, bool record);

}  // namespace lodestar
