// The learning half of SD-tree guiding (Mueller et al. 2017; Mueller 2019): core/guiding's tree as a method's state,
// its sums as statistics. Iteration k has 2^k passes.
#pragma once

#include "core/film/pixel_estimate.h"
#include "core/guiding/sd_tree.h"
#include "core/guiding/sd_tree_statistics.h"
#include "core/learning/learned_sums.h"
#include "core/learning/method.h"
#include "core/learning/nee.h"
#include "core/learning/roulette.h"

namespace lodestar {

class SdTreeState final : public State {
 public:
  // `pixels` is empty where neither target nor roulette need it.
  SdTreeState(std::shared_ptr<const SdTree> tree, PixelEstimate pixels)
      : tree_(std::move(tree)), pixels_(std::move(pixels)) {}
  // Throws Error(kCorrupt).
  static std::shared_ptr<const SdTreeState> Parse(std::string_view bytes);
  const SdTree& tree() const { return *tree_; }
  const std::shared_ptr<const SdTree>& shared_tree() const { return tree_; }
  const PixelEstimate& pixels() const { return pixels_; }
  Bytes Serialize() const override;

 private:
  std::shared_ptr<const SdTree> tree_;
  PixelEstimate pixels_;
};

using SdTreeGuidingStatistics = LearnedSums<SdTreeStatistics>;

class SdTreeMethod final : public Method {
 public:
  // What is recorded of emission that next event estimation could have found: all, its share by multiple importance
  // sampling, nothing.
  enum class Learn : uint8_t { kAll, kWeighted, kIndirect };
  struct Options {
    SdTreeOptions tree = SdTreeOptions::Recommended();
    NeeMode nee = NeeMode::kLearned;
    Learn learn = Learn::kWeighted;
    bool learn_lights = true;  // which lights to sample, per leaf; else by power
    bool product = false;      // guide by tree times BSDF
    Roulette roulette = Roulette::kPixel;
    Combination combination = Combination::kInverseVariance;
    int training = -1;  // iterations; -1: decided by the budget
  };
  // Throws Error(kInvalidInput) for options it does not have or values they cannot take.
  SdTreeMethod(const JobSpec& job, const Survey& survey);
  static MethodEntry Entry();

  const Options& options() const { return options_; }

  std::string_view name() const override { return "sdtree"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State&, uint32_t iteration) const override {
    return uint64_t{1} << std::min(iteration, 32u);
  }
  Combination combination() const override { return options_.combination; }
  int TrainingIterations() const override { return options_.training; }

 private:
  bool NeedsPixels(const SdTree& tree) const;

  Options options_;
  Bounds3 bounds_;
  std::vector<float> light_groups_;  // empty: selected by power
  uint32_t resolution_x_, resolution_y_;
};

}  // namespace lodestar
