// The learning half of plain path tracing: there is nothing to learn, one iteration lasts for the whole job, and all
// its samples enter one film.
#pragma once

#include "core/learning/method.h"
#include "core/learning/nee.h"

namespace lodestar {

class PathMethod final : public Method {
 public:
  struct Options {
    NeeMode nee = NeeMode::kAlways;  // never or always
  };
  // Throws Error(kInvalidInput) for options it does not have.
  explicit PathMethod(const JobSpec& job);
  static MethodEntry Entry();

  const Options& options() const { return options_; }

  std::string_view name() const override { return "path"; }
  std::shared_ptr<const State> Initial() const override;
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override;
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>&) const override { return nullptr; }
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult&) const override {
    return state;
  }
  uint64_t IterationPasses(const State&, uint32_t) const override { return 0; }
  Combination combination() const override { return Combination::kDiscard; }

 private:
  Options options_;
};

}  // namespace lodestar
