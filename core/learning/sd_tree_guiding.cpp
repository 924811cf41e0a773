#include "core/learning/sd_tree_guiding.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/guiding/sd_tree_advance.h"

namespace lodestar {

Bytes SdTreeState::Serialize() const {
  ByteWriter out;
  out.PutString(tree_->Serialize());
  pixels_.Write(out);
  return out.Take();
}

std::shared_ptr<const SdTreeState> SdTreeState::Parse(std::string_view bytes) {
  ByteReader in(bytes, "guiding state");
  auto tree = SdTree::Parse(in.GetString());
  PixelEstimate pixels = PixelEstimate::Read(in);
  in.ExpectEnd();
  return std::make_shared<SdTreeState>(std::move(tree), std::move(pixels));
}

std::shared_ptr<const State> SdTreeMethod::Initial() const {
  return std::make_shared<SdTreeState>(SdTree::Initial(bounds_, options_.tree, light_groups_), PixelEstimate{});
}

std::shared_ptr<const State> SdTreeMethod::ParseState(std::string_view bytes) const {
  auto state = SdTreeState::Parse(bytes);
  CheckOptions(state->tree().options(), options_.tree, "a guiding state");
  if (!std::ranges::equal(state->tree().lights_by_power(),
                          SdTree::Initial(bounds_, options_.tree, light_groups_)->lights_by_power()))
    throw Error(ErrorKind::kConflict, "a guiding state was made for other lights than its job's; submit the job again");
  const bool complete = !NeedsPixels(state->tree()) || !state->pixels().empty();
  if (!complete || (!state->pixels().empty() &&
                    (state->pixels().width != resolution_x_ || state->pixels().height != resolution_y_))) {
    throw Error(ErrorKind::kCorrupt, "a guiding state has a pixel estimate of another size than its job's image");
  }
  return state;
}

bool SdTreeMethod::NeedsPixels(const SdTree& tree) const {
  return tree.target() == SdTreeOptions::Target::kFull ||
         (options_.roulette == Roulette::kPixel && tree.iteration() > 0);
}

std::unique_ptr<Statistics> SdTreeMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  return std::make_unique<SdTreeGuidingStatistics>(SdTreeStatistics(As<SdTreeState>(*state).shared_tree()));
}

std::shared_ptr<const State> SdTreeMethod::Advance(const std::shared_ptr<const State>& state,
                                                   const IterationResult& result) const {
  if (result.statistics == nullptr) return state;
  const auto& learned = As<SdTreeGuidingStatistics>(*result.statistics);
  auto tree = lodestar::Advance(As<SdTreeState>(*state).tree(), learned.sums(), static_cast<double>(result.passes), {},
                                result.shards);
  PixelEstimate pixels;
  if (NeedsPixels(*tree)) {
    LODESTAR_CHECK(result.image != nullptr);
    pixels = EstimatePixels(*result.image);
  }
  return std::make_shared<SdTreeState>(std::move(tree), std::move(pixels));
}

}  // namespace lodestar
