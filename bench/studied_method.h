// SD-tree guiding whose learning half a study changes or looks into.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "core/guiding/sd_tree_advance.h"
#include "core/learning/sd_tree_guiding.h"

namespace lodestar {

class StudiedMethod final : public Method {
 public:
  // What an iteration left behind, already of the method's own types.
  using Recorded =
      std::function<void(const std::shared_ptr<const SdTree>&, const SdTreeStatistics&, const IterationResult&)>;
  using Reconstruct = std::function<SdTreeOptions::Reconstruction(const IterationResult&)>;
  using Passes = std::function<uint64_t(uint32_t iteration)>;

  // Reconstructs as `reconstruct` says for each iteration; 2^k passes in iteration k where `passes` is empty.
  StudiedMethod(const JobSpec& job, const Survey& survey, Reconstruct reconstruct, Recorded recorded = {},
                Passes passes = {})
      : inner_(job, survey),
        reconstruct_(std::move(reconstruct)),
        recorded_(std::move(recorded)),
        passes_(std::move(passes)) {}

  std::string_view name() const override { return inner_.name(); }
  std::shared_ptr<const State> Initial() const override { return inner_.Initial(); }
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override { return inner_.ParseState(bytes); }
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override {
    return inner_.NewStatistics(state);
  }
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override {
    if (result.statistics == nullptr) return state;
    const auto& tree = dynamic_cast<const SdTreeState&>(*state).shared_tree();
    const SdTreeStatistics& sums = dynamic_cast<const SdTreeGuidingStatistics&>(*result.statistics).sums();
    if (recorded_) recorded_(tree, sums, result);
    return std::make_shared<SdTreeState>(
        lodestar::Advance(*tree, sums, static_cast<double>(result.passes), reconstruct_(result)),
        EstimatePixels(*result.image));
  }
  uint64_t IterationPasses(const State& state, uint32_t iteration) const override {
    return passes_ ? passes_(iteration) : inner_.IterationPasses(state, iteration);
  }
  Combination combination() const override { return inner_.combination(); }

 private:
  SdTreeMethod inner_;
  Reconstruct reconstruct_;
  Recorded recorded_;
  Passes passes_;
};

}  // namespace lodestar
