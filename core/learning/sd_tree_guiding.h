// The learning half of SD-tree guiding (Mueller et al. 2017; Mueller 2019): core/guiding's tree as a method's state,
// its sums as statistics. Iteration k has 2^k passes.
#pragma once

#include "core/guiding/sd_tree.h"
#include "core/guiding/sd_tree_statistics.h"
#include "core/learning/method.h"
#include "core/learning/nee.h"

namespace lodestar {

class SdTreeState final : public State {
 public:
  explicit SdTreeState(std::shared_ptr<const SdTree> tree) : tree_(std::move(tree)) {}
  const SdTree& tree() const { return *tree_; }
  const std::shared_ptr<const SdTree>& shared_tree() const { return tree_; }
  Bytes Serialize() const override { return tree_->Serialize(); }

 private:
  std::shared_ptr<const SdTree> tree_;
};

class SdTreeGuidingStatistics final : public Statistics {
 public:
  explicit SdTreeGuidingStatistics(SdTreeStatistics sums) : sums_(std::move(sums)) {}
  SdTreeStatistics& sums() { return sums_; }
  const SdTreeStatistics& sums() const { return sums_; }
  void Merge(const Statistics& other) override;  // of the same tree
  Bytes Serialize() const override { return sums_.Serialize(); }

 private:
  SdTreeStatistics sums_;
};

class SdTreeMethod final : public Method {
 public:
  struct Options {
    SdTreeOptions tree;
    NeeMode nee = NeeMode::kAlways;
    Combination combination;
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
  std::unique_ptr<Statistics> ParseStatistics(const std::shared_ptr<const State>& state,
                                              std::string_view bytes) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(uint32_t iteration) const override { return uint64_t{1} << std::min(iteration, 32u); }
  Combination combination() const override { return options_.combination; }
  int TrainingIterations() const override { return options_.training; }

 private:
  Options options_;
  Bounds3 bounds_;
};

}  // namespace lodestar
