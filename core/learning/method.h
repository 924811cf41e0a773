// The learning half of a method: it knows no scene and no ray. A method is `initial -> (plan -> units -> merge ->
// advance)*`, and the loop (loop.h) drives it; the tracing half (core/tracing) renders its units. One instance serves
// one job.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/health.h"
#include "core/base/shards.h"
#include "core/film/film.h"
#include "core/learning/job.h"
#include "core/learning/round.h"

namespace lodestar {

// What all workers of an iteration share, immutable once published. Its canonical bytes are what is hashed and sent.
class State {
 public:
  virtual ~State() = default;
  virtual Bytes Serialize() const = 0;
};

// What units learned. Merging is exact: associative and commutative to the bit (integers, fixed-point sums, disjoint
// unions), so that neither threads nor workers nor the order of arrival can show in a result
// (docs/decisions/0002-exact-sums.md).
class Statistics {
 public:
  virtual ~Statistics() = default;
  virtual void Merge(const Statistics& other) = 0;  // of the same type and state
  virtual Bytes Serialize() const = 0;
  // Adds what Serialize() wrote. Throws Error(kCorrupt), and kConflict for another state's; then nothing has changed.
  virtual void MergeSerialized(std::string_view bytes) = 0;
  // Counts what was left out of them or changed.
  virtual void AddHealth(HealthReport* health) const {}
};

// A state or statistics of the type that a method made them of.
template <class T, class Base>
const T& As(const Base& base) {
  const auto* cast = dynamic_cast<const T*>(&base);
  LODESTAR_CHECK(cast != nullptr);
  return *cast;
}
// Throws Error(kConflict) where a state that was read, `what`, has other options than its job gives it.
template <class Options>
void CheckOptions(const Options& of_state, const Options& of_job, const char* what) {
  if (!(of_state == of_job))
    throw Error(ErrorKind::kConflict,
                std::string(what) + " was made with other options than its job's; submit the job again");
}

// The result of some node of a round's tree: the tiles of its units, and what they learned. Absent parts are absent,
// not zero.
struct Contribution {
  std::vector<FilmTile> tiles;             // ascending by tile, no tile twice
  std::unique_ptr<Statistics> statistics;  // null: nothing was recorded
  HealthReport health;
  uint64_t paths = 0, rays = 0, vertices = 0;

  // Adds the contribution of other units of the same round and leaves it empty.
  void Merge(Contribution&& other);
};

// What an iteration rendered, or several iterations of one candidate (combination.h); then `iteration` is the first.
struct IterationFilm {
  uint32_t iteration = 0;
  Film film;
  uint32_t candidate = 0;           // who rendered it: Method::Active's
  uint64_t rays = 0, vertices = 0;  // what it cost
  double seconds = 0;               // the same, by the clock: for the loop alone
};

// What an iteration leaves behind, for Method::Advance.
struct IterationResult {
  const Statistics* statistics = nullptr;  // null: no unit recorded anything
  uint32_t iteration = 0;
  uint64_t passes = 0;                        // of this iteration
  const Image* image = nullptr;               // the job's image so far; null where there is none
  std::span<const IterationFilm> films = {};  // those it is made of; this iteration's is the last
  bool last = false;                          // training ends here: the state to come renders the rest of the job
  bool late = false;  // another iteration would end beyond a quarter of the budget, as far as can be predicted
  ShardRunner* shards = nullptr;  // who does what can be done in shards; null: this process
};

struct OptionHelp {
  std::string name, values, default_value, help;
};

class Method {
 public:
  virtual ~Method() = default;
  virtual std::string_view name() const = 0;
  virtual std::shared_ptr<const State> Initial() const = 0;
  virtual std::shared_ptr<const State> ParseState(std::string_view bytes) const = 0;
  // Null for methods that learn nothing.
  virtual std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const = 0;
  virtual std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                               const IterationResult& result) const = 0;
  // Passes of iteration k if the job goes on for ever; 0: unbounded (a method that learns nothing, or has stopped).
  // `state` is the iteration's own, or an earlier one's: then they are what is expected so far.
  virtual uint64_t IterationPasses(const State& state, uint32_t iteration) const = 0;

  // What renders under a state: the method itself with it; of a method that chooses among others, the one it has chosen
  // so far with that one's own state. Lives as long as this method.
  struct Active {
    const Method* method;
    std::shared_ptr<const State> state;
    uint32_t candidate = 0;  // its number among those that are chosen from
  };
  virtual Active ActiveUnder(const std::shared_ptr<const State>& state) const { return {this, state}; }
  // How many it chooses from.
  virtual uint32_t candidates() const { return 1; }

  // Options that were left to the method and that it derived from the budget: as it has decided under a state, for a
  // replay of the job by passes, which has another budget.
  virtual std::map<std::string, std::string> DecidedOptions(const State& state) const { return {}; }

  // True where a state has nothing more to learn: the iteration under it is the last.
  virtual bool Decided(const State& state) const { return false; }
  // For the report, after "chose": what the method chose and left out, and why, or what its user must know of its
  // options; empty where there is nothing to say.
  virtual std::string Explain(const State& state) const { return {}; }

  // How the films of iterations become the image (combination.h).
  enum class Combination { kDiscard, kAutomatic, kInverseVariance };
  virtual Combination combination() const { return Combination::kInverseVariance; }
  // Iterations to train where the method's own options fix them; -1: the loop decides (JobSpec::training_iterations
  // comes first).
  virtual int TrainingIterations() const { return -1; }
};

// Adds serialized statistics of a state to `sum`, which is made where there is none yet. Throws as MergeSerialized
// does, and Error(kCorrupt) where the method learns nothing.
void AddStatistics(const Method& method, const std::shared_ptr<const State>& state, std::string_view bytes,
                   std::unique_ptr<Statistics>* sum);

// The registry: the one place that names methods.
struct MethodEntry {
  std::string name, summary;
  std::vector<OptionHelp> options;
};
std::span<const MethodEntry> Methods();
// Throws Error(kInvalidInput) for an unknown method (listing those there are) or option (listing the method's).
std::unique_ptr<Method> MakeMethod(const JobSpec& job, const Survey& survey);

}  // namespace lodestar
