// A method that keeps, of each advance, what it came from; else it is the one it wraps.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "core/learning/guide_file.h"

namespace lodestar {

class ObservedMethod final : public Method {
 public:
  ObservedMethod(std::unique_ptr<Method> method, std::optional<GuideFile::Training>* last)
      : method_(std::move(method)), last_(last) {}

  std::string_view name() const override { return method_->name(); }
  std::shared_ptr<const State> Initial() const override { return method_->Initial(); }
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override { return method_->ParseState(bytes); }
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override {
    return method_->NewStatistics(state);
  }
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State& state, uint32_t iteration) const override {
    return method_->IterationPasses(state, iteration);
  }
  Active ActiveUnder(const std::shared_ptr<const State>& state) const override { return method_->ActiveUnder(state); }
  std::map<std::string, std::string> DecidedOptions() const override { return method_->DecidedOptions(); }
  bool Decided(const State& state) const override { return method_->Decided(state); }
  std::string Explain(const State& state) const override { return method_->Explain(state); }
  Combination combination() const override { return method_->combination(); }
  int TrainingIterations() const override { return method_->TrainingIterations(); }

 private:
  std::unique_ptr<Method> method_;
  std::optional<GuideFile::Training>* last_;
};

}  // namespace lodestar
