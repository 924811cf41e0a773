// The loop: state -> rounds -> merge -> advance, written once. It takes an executor (threads of this process, or leases of the farm), decides stops
// at round edges, accumulates the image, and records error against run time. Its whole position can be checkpointed and restored.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/clock.h"
#include "core/base/stop.h"
#include "core/film/error_metrics.h"
#include "core/learning/method.h"

namespace lodestar {

// Renders rounds. Implementations: tracing/LocalExecutor, coordinator/FarmExecutor.
class Executor {
 public:
  virtual ~Executor() = default;
  // Blocks until every unit of the round is merged; nothing where `stop` was requested first.
  virtual std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round, const StopToken& stop) = 0;
};

// One point of error against run time.
struct ErrorPoint {
  double seconds = 0;
  uint64_t spp = 0;        // passes rendered so far, training included
  uint32_t iteration = 0;
  double relmse_estimated = 0;          // trimmed, from the pixel variances
  std::optional<ErrorMetrics> against_reference;
};

struct JobProgress {
  uint32_t iteration = 0;
  uint64_t passes = 0;
  double seconds = 0;
  double relmse_estimated = 0;
  double fraction = 0;               // of the nearest budget
  double seconds_left = -1;          // -1: unknown
  uint64_t rays = 0, paths = 0, vertices = 0;
};

struct JobReport {
  JobSpec job;
  Survey survey;
  std::vector<ErrorPoint> points;
  HealthReport health;
  uint64_t passes = 0;
  uint32_t iterations = 0;
  int training_iterations = 0;       // with `passes`, what a replay needs
  double seconds = 0, seconds_learning = 0;
  uint64_t rays = 0, paths = 0, vertices = 0;
  std::string stop_reason;           // "spp", "time", "error", "stopped"
};

class Loop {
 public:
  struct Hooks {
    std::function<void(const JobProgress&)> progress;                    // after each round
    std::function<void(const Loop&)> checkpoint;                          // at safe points: after each round and each advance
    std::shared_ptr<const Image> reference;                               // error points are measured against it where given
  };

  Loop(const JobSpec& job, const Survey& survey);
  // From Checkpoint(); throws Error(kCorrupt) or (kConflict) on bytes of another version.
  static std::unique_ptr<Loop> Restore(std::string_view checkpoint);

  // Runs to the budget or to a stop request (which leaves the loop at the last round's edge).
  void Run(Executor& executor, const StopToken& stop, const Hooks& hooks, const Clock& clock = Clock::Steady());

  Image Develop() const;                     // the image so far
  JobReport Report() const;
  Bytes Checkpoint() const;
  bool finished() const { return finished_; }
  const Method& method() const { return *method_; }
  const std::shared_ptr<const State>& state() const { return state_; }
  const JobSpec& job() const { return job_; }
  const Survey& survey() const { return survey_; }
  // The round Run() would execute next (or is executing).
  Round NextRound() const;

 private:
  // Iteration films that still can enter the image.
  struct IterationFilm {
    uint32_t iteration = 0;
    Film film;
  };
  JobSpec job_;
  Survey survey_;
  TileGrid grid_;
  std::unique_ptr<Method> method_;
  std::shared_ptr<const State> state_;
  std::vector<IterationFilm> films_;
  std::unique_ptr<Statistics> learned_;      // of the current iteration, rounds merged in order
  uint32_t iteration_ = 0, round_ = 0;
  uint64_t iteration_passes_ = 0, passes_ = 0;
  bool final_iteration_ = false, finished_ = false;
  double seconds_ = 0, seconds_learning_ = 0;
  JobReport report_;
};

// Passes in a round: enough samples that a round's overhead vanishes and few enough that budgets by time are met closely; a function of the
// resolution alone.
uint32_t PassesPerRound(uint32_t width, uint32_t height);

}  // namespace lodestar
