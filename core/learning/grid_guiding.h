// The learning half of grid guiding (Kim 2022): core/guiding's radiance grid as a method's state, its sums as
// statistics. A training iteration is a step of the document: a batch of passes under the previous step's table.
#pragma once

#include "core/guiding/grid_sampling.h"
#include "core/guiding/grid_statistics.h"
#include "core/learning/learned_sums.h"
#include "core/learning/method.h"
#include "core/learning/nee.h"

namespace lodestar {

class GridState final : public State {
 public:
  explicit GridState(std::shared_ptr<const RadianceGrid> grid) : grid_(std::move(grid)) {}
  const std::shared_ptr<const RadianceGrid>& grid() const { return grid_; }
  Bytes Serialize() const override { return grid_->Serialize(); }

 private:
  std::shared_ptr<const RadianceGrid> grid_;
};

using GridGuidingStatistics = LearnedSums<GridStatistics>;

class GridMethod final : public Method {
 public:
  // What an entry learns from a path that left through it (Kim 2022, chapter 4).
  enum class Learn : uint8_t {
    kMonteCarlo,     // what the rest of the path brought
    kSarsa,          // the next vertex's light and what the table says of its next direction
    kExpectedSarsa,  // the next vertex's light and what the table says of all its directions
  };
  struct Options {
    GridOptions grid;
    GridRules rules;
    Learn learn = Learn::kExpectedSarsa;
    NeeMode nee = NeeMode::kAlways;
    Combination combination = Combination::kInverseVariance;
    float bsdf_fraction = 0.5f;
    uint32_t exploration = 1;  // steps that are not guided yet; at most `steps` where there are any
    uint64_t batch = 8;        // passes of a step
    uint32_t steps = 0;
  };
  // Throws Error(kInvalidInput) for options it does not have or values they cannot take.
  GridMethod(const JobSpec& job, const Survey& survey);
  static MethodEntry Entry();

  const Options& options() const { return options_; }

  std::string_view name() const override { return "grid"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State&, uint32_t iteration) const override {
    return iteration < options_.steps ? options_.batch : 0;
  }
  // With a memo: that it is biased, and by how much.
  std::string Explain(const State& state) const override;
  std::map<std::string, std::string> DecidedOptions(const State&) const override {
    return {{"exploration", std::to_string(options_.exploration)}, {"steps", std::to_string(options_.steps)}};
  }
  Combination combination() const override { return options_.combination; }

 private:
  Options options_;
  Bounds3 bounds_;
};

}  // namespace lodestar
