// The learning half of focal guiding (Rath et al. 2023; Sadek 2025): core/guiding's focal field as a method's state,
// its sums as statistics. Every training iteration has the same number of passes.
#pragma once

#include "core/guiding/focal_field.h"
#include "core/guiding/focal_statistics.h"
#include "core/learning/learned_sums.h"
#include "core/learning/method.h"
#include "core/learning/nee.h"

namespace lodestar {

class FocalState final : public State {
 public:
  explicit FocalState(std::shared_ptr<const FocalField> field) : field_(std::move(field)) {}
  const FocalField& field() const { return *field_; }
  const std::shared_ptr<const FocalField>& shared_field() const { return field_; }
  Bytes Serialize() const override { return field_->Serialize(); }

 private:
  std::shared_ptr<const FocalField> field_;
};

using FocalGuidingStatistics = LearnedSums<FocalStatistics>;

class FocalMethod final : public Method {
 public:
  struct Options {
    FocalOptions field;
    NeeMode nee = NeeMode::kAlways;
    Combination combination = Combination::kInverseVariance;
    uint64_t passes = 1;  // of a training iteration
  };
  // Throws Error(kInvalidInput) for options it does not have or values they cannot take.
  FocalMethod(const JobSpec& job, const Survey& survey);
  static MethodEntry Entry();

  const Options& options() const { return options_; }

  std::string_view name() const override { return "focal"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override;
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State&, uint32_t iteration) const override {
    return iteration < options_.field.iterations() ? options_.passes : 0;
  }
  std::map<std::string, std::string> DecidedOptions(const State&) const override {
    return {{"passes", std::to_string(options_.passes)}};
  }
  Combination combination() const override { return options_.combination; }

 private:
  Options options_;
  Bounds3 bounds_;
};

}  // namespace lodestar
