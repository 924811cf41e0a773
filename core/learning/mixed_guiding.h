// SD-tree and focal guiding in one mixture: p = beta (alpha p_bsdf + (1 - alpha) p_tree) + (1 - beta) p_focal. The tree
// learns alpha per leaf, and light, as it does alone; the focal field learns beta per cell, with the tree's mixture in
// the place of the BSDF (docs/decisions/0020-mixture.md). Each learns from every path, whoever drew its directions.
#pragma once

#include "core/learning/focal_guiding.h"
#include "core/learning/sd_tree_guiding.h"

namespace lodestar {

class MixedState final : public State {
 public:
  MixedState(std::shared_ptr<const SdTreeState> tree, std::shared_ptr<const FocalState> focal)
      : tree_(std::move(tree)), focal_(std::move(focal)) {}
  const std::shared_ptr<const SdTreeState>& tree() const { return tree_; }
  const std::shared_ptr<const FocalState>& focal() const { return focal_; }
  Bytes Serialize() const override;

 private:
  std::shared_ptr<const SdTreeState> tree_;
  std::shared_ptr<const FocalState> focal_;
};

class MixedStatistics final : public Statistics {
 public:
  MixedStatistics(SdTreeStatistics tree, FocalStatistics focal) : tree_(std::move(tree)), focal_(std::move(focal)) {}
  SdTreeGuidingStatistics& tree() { return tree_; }
  const SdTreeGuidingStatistics& tree() const { return tree_; }
  FocalGuidingStatistics& focal() { return focal_; }
  const FocalGuidingStatistics& focal() const { return focal_; }

  void Merge(const Statistics& other) override;
  Bytes Serialize() const override;
  void MergeSerialized(std::string_view bytes) override;
  void AddHealth(HealthReport* health) const override;

 private:
  SdTreeGuidingStatistics tree_;
  FocalGuidingStatistics focal_;
};

// Iterations grow by the square root of two, not by two as those of the tree alone: narrowing takes a level each.
class MixedMethod final : public Method {
 public:
  // Throws Error(kInvalidInput) for options it does not have or values they cannot take.
  MixedMethod(const JobSpec& job, const Survey& survey);
  static MethodEntry Entry();

  const SdTreeMethod& tree() const { return tree_; }

  std::string_view name() const override { return "sdtree+focal"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State& state, uint32_t iteration) const override;
  Combination combination() const override { return tree_.combination(); }
  int TrainingIterations() const override { return tree_.TrainingIterations(); }

 private:
  SdTreeMethod tree_;
  FocalMethod focal_;
};

}  // namespace lodestar
